//! Tri-dexel stock, swept volume, material removal, surface extraction.
