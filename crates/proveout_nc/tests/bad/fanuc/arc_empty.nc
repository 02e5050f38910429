(nc-arc-geometry)
G0 X0. Y0. Z0.
G2 X10. R0. F100.
