(nc-unsupported-word)
O100 SUB
