(nc-missing-value)
G0 X0. Y0. Z10.
G81 X1. Z-5. F100.
