//! placeholder until the collision crate lands
