(nc-subprogram)
M98 P777
