(nc-position-unknown)
G68.2 X0. Y0. Z0. I0. J30. K0.
G53.1
G0 X1. Y1.
G1 X2. F100.
G69
