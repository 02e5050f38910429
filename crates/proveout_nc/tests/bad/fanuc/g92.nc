(nc-position-unknown)
G92 X0 Y0
