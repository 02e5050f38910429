(nc-arc-radius)
G0 X0. Y0. Z0.
G2 X10. Y0. I4. F100.
