//! Deviation, scallop height, roughness.
