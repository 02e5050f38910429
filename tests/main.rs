//! Whole prove-outs, keys that must change a result, and injected faults, in one program: it links once.

mod injection;
mod keys;
mod prove_out;
