(nc-no-tool)
M6
