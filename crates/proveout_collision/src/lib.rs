//! Interference of tool assembly, machine, fixtures, part and in-process stock.
