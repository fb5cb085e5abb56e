# python3 dandelion.py dandelion.splat writes what a trained file would hold, made by rule. 32 bytes a splat:
# position, scales, colour and opacity, rotation w x y z.
import math, random, struct, sys
random.seed(7)
def quat_from_z(d):
    # turns +z to the unit vector d
    w = 1.0 + d[2]
    if w < 1e-9: return (0.0, 1.0, 0.0, 0.0)
    x, y, z = -d[1], d[0], 0.0
    n = math.sqrt(w*w + x*x + y*y)
    return (w/n, x/n, y/n, z/n)
def byte(v): return max(0, min(255, int(round(v))))
out = bytearray()
def splat(p, s, rgba, q):
    out.extend(struct.pack('<6f', *p, *s))
    out.extend(bytes(byte(255*c) for c in rgba))
    out.extend(bytes(byte((c+1)*127.5) for c in q))
def along(a, b, k): return tuple(a[i] + (b[i]-a[i])*k for i in range(3))
golden = math.pi*(3-math.sqrt(5))
n = 150
for i in range(n):
    y = 1 - 2*(i+0.5)/n; r = math.sqrt(1-y*y); a = golden*i
    d = (r*math.cos(a), y, r*math.sin(a))
    if d[1] > 0.93: continue
    q = quat_from_z(d)
    # the stalk of a seed
    for k in (0.25, 0.45, 0.65): splat(along((0,0,0), d, k), (0.004, 0.004, 0.07), (0.62, 0.55, 0.38, 0.85), q)
    splat(along((0,0,0), d, 0.14), (0.012, 0.012, 0.05), (0.32, 0.2, 0.1, 0.98), q)
    # its parachute: hairs around the end
    ax = (1-2*(q[2]**2+q[3]**2), 2*(q[1]*q[2]+q[0]*q[3]), 2*(q[1]*q[3]-q[0]*q[2]))
    bx = (2*(q[1]*q[2]-q[0]*q[3]), 1-2*(q[1]**2+q[3]**2), 2*(q[2]*q[3]+q[0]*q[1]))
    for h in range(11):
        t = 2*math.pi*(h + random.random()*0.5)/11; tilt = 0.75 + 0.25*random.random()
        hair = tuple(math.cos(tilt)*d[c] + math.sin(tilt)*(math.cos(t)*ax[c] + math.sin(t)*bx[c]) for c in range(3))
        tip = tuple(0.8*d[c] + 0.11*hair[c] for c in range(3))
        white = 0.78 + 0.22*random.random()
        splat(tip, (0.0035, 0.0035, 0.075), (white, white, 0.97*white, 0.7), quat_from_z(hair))
        end = tuple(0.8*d[c] + 0.21*hair[c] for c in range(3))
        splat(end, (0.012, 0.012, 0.012), (1.0, 1.0, 0.98, 0.25), (1, 0, 0, 0))
# core and stem, y down as in trained files
for i in range(60):
    y = 1 - 2*(i+0.5)/60; r = math.sqrt(1-y*y); a = golden*i
    splat((0.07*r*math.cos(a), 0.07*y, 0.07*r*math.sin(a)), (0.03, 0.03, 0.03), (0.28, 0.33, 0.12, 0.95), (1, 0, 0, 0))
for i in range(60):
    k = i/59.0
    splat((0.12*k*k, 0.05 + 1.9*k, 0.0), (0.03, 0.035, 0.03), (0.30 + 0.08*random.random(), 0.42, 0.16, 0.95), (1, 0, 0, 0))
open(sys.argv[1], 'wb').write(out)
print(len(out)//32, 'splats')
