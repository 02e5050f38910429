(nc-arguments)
G0 X0. Y0. Z10.
G81 Z5. R2. F100.
