(nc-orientation)
G0 A0. C0.
G43.5 H1 X0. Y0. Z0.
G1 X1. I0. J0. K0. F100.
