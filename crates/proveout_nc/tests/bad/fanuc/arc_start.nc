(nc-position-unknown)
G2 X10. Y0. I4. F100.
