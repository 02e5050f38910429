(nc-arc-geometry)
G21 G0 X10. Y10. Z0.
G2 X20. Y20. F100.
M30
