//! Cutter location data, APT CL files, path planning, orientation re-scheduling.
