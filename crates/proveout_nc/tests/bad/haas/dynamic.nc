(nc-conflicting-words)
G0 B30. C0.
G254
C10.
