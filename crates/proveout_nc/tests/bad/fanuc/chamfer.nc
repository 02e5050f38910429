(nc-arc-geometry)
G0 X0 Y0
G1 X10. ,C1. F100.
