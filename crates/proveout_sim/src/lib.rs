//! Scenes, the prove-out loop, findings, gates, observers.
