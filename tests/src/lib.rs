//! Whole prove-outs, reference data and laws.
