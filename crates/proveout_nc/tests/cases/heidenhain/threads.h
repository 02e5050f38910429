0 BEGIN PGM THREADS MM
; radius of the tool 6 (Q108); threads of 20 mm, so that its center runs on 4 mm
1 TOOL CALL 1 Z S2000 F500
2 L X+10 Y+20 Z+50 R0 FMAX M3
; 263: Z -3 with Q253, half circle to 2.5 off the middle, around, back; one turn up from Z -10 to -8
3 CYCL DEF 263 THREAD MLLNG/CNTSNKG ~
    Q335=+20 ~
    Q239=+2 ~
    Q201=-10 ~
    Q356=+0 ~
    Q253=+750 ~
    Q351=+1 ~
    Q200=+2 ~
    Q357=+0.2 ~
    Q358=-3 ~
    Q359=+2.5 ~
    Q203=+0 ~
    Q204=+20 ~
    Q254=+150 ~
    Q207=+300
4 CYCL CALL
; 264: infeeds of 5 to Z -12 with stops 0.5 above the last; left-hand thread in climb: one turn down from -8 to -10
5 CYCL DEF 264 THREAD DRILLNG/MLLNG ~
    Q335=+20 ~
    Q239=-2 ~
    Q201=-10 ~
    Q356=-12 ~
    Q253=+750 ~
    Q351=+1 ~
    Q202=+5 ~
    Q258=+0.5 ~
    Q257=+0 ~
    Q256=+0.2 ~
    Q358=+0 ~
    Q359=+0 ~
    Q200=+2 ~
    Q203=+0 ~
    Q204=+20 ~
    Q206=+150 ~
    Q207=+300
6 L X+60 Y+20 FMAX M99
; 265: a helix of five turns down to Z -10, clockwise; then the countersink, with Q253 to its depth
7 CYCL DEF 265 HEL. THREAD DRLG/MLG ~
    Q335=+20 ~
    Q239=+2 ~
    Q201=-10 ~
    Q253=+750 ~
    Q358=-1 ~
    Q359=+1 ~
    Q360=+1 ~
    Q200=+2 ~
    Q203=+0 ~
    Q204=+20 ~
    Q254=+150 ~
    Q207=+300
8 L X+10 Y+60 FMAX M99
9 L Z+100 FMAX M30
10 END PGM THREADS MM
