import sys, time
import numpy as np
from dataclasses import replace
from tests.reproduction.independent.runs import RUNS
from prp_gym.reproduction import load_catalogue, record_run
from prp_gym.reproduction.signals import series
cat=load_catalogue()
names=sys.argv[1:] or list(RUNS)
for n in names:
    if n not in cat.runs: print(n,"not declared"); continue
    t0=time.process_time(); s=RUNS[n](); t1=time.process_time(); r=record_run(cat.runs[n]).rollout; t2=time.process_time()
    out=[]
    for sig in ("joint_position","end_effector_pose","contact_force","torque","joint_error","pose_error","parameter_estimate"):
        if sig not in s: continue
        try: tt,v=series(r,sig)
        except Exception as e: continue
        w=s[sig][:len(v)]
        d=np.nanmax(np.abs(v-w),axis=0)
        out.append(f"{sig}: {d.max():.2e}/{np.nanmax(np.abs(w)):.3g}")
    print(n, f"{t1-t0:.1f}s {t2-t1:.1f}s", "; ".join(out), flush=True)
