(nc-no-feed)
G1 X10.
