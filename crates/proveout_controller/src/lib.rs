//! Offsets, RTCP, path smoothing, look-ahead feed planning, interpolation.
