(nc-unknown-variable)
G0 X#500
