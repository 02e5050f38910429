(nc-arguments)
G0 X0. Y0. Z10.
G83 X1. Z-5. R1. F100.
