(nc-missing-value)
G51 X0 Y0 I2000 J2000
