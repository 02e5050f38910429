(nc-probe)
G0 X#5061
