(nc-position-unknown)
G91 G0 X5.
