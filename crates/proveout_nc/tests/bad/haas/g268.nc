(nc-unsupported-word)
G268 X0 Y0 Z0 I0 J30. K0
