(nc-position-unknown)
G254
