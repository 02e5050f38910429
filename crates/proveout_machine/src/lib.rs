//! Machine description, forward and inverse kinematics, travel and drive limits.
