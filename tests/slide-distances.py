#!/usr/bin/python3
# How far what slides is from what it slides on, beside that at rest: the mean over all free vertices with candidates, and the mean change.
# Usage: slide-distances.py DOCUMENTS FRAMES [FRAME...]: the folder of the tied muscles, that of their point caches; the last frame.
import json,glob,math,struct,sys
folder, frames = sys.argv[1:3]
docs={}
for f in glob.glob(folder + '/*.muscle.json'):
    d=json.load(open(f)); docs[d['name']]=d
def last(name,frame=-1):
    b=open(frames+'/'+name+'.pc2','rb').read(); n=struct.unpack('<i',b[16:20])[0]; s=struct.unpack('<i',b[28:32])[0]
    if frame<0: frame=s-1
    v=struct.unpack('<%df'%(3*n),b[32+12*n*frame:32+12*n*(frame+1)]); return [v[i:i+3] for i in range(0,3*n,3)]
def closest(p,a,b,c):
    def sub(x,y): return (x[0]-y[0],x[1]-y[1],x[2]-y[2])
    def dot(x,y): return x[0]*y[0]+x[1]*y[1]+x[2]*y[2]
    ab,ac,ap=sub(b,a),sub(c,a),sub(p,a)
    d1,d2=dot(ab,ap),dot(ac,ap)
    if d1<=0 and d2<=0: return a
    bp=sub(p,b); d3,d4=dot(ab,bp),dot(ac,bp)
    if d3>=0 and d4<=d3: return b
    vc=d1*d4-d3*d2
    if vc<=0 and d1>=0 and d3<=0: t=d1/(d1-d3); return tuple(a[i]+t*ab[i] for i in range(3))
    cp=sub(p,c); d5,d6=dot(ab,cp),dot(ac,cp)
    if d6>=0 and d5<=d6: return c
    vb=d5*d2-d1*d6
    if vb<=0 and d2>=0 and d6<=0: t=d2/(d2-d6); return tuple(a[i]+t*ac[i] for i in range(3))
    va=d3*d6-d5*d4
    if va<=0 and d4-d3>=0 and d5-d6>=0: t=(d4-d3)/((d4-d3)+(d5-d6)); return tuple(b[i]+t*(c[i]-b[i]) for i in range(3))
    e=1/(va+vb+vc); v,w=vb*e,vc*e
    return tuple(a[i]+v*ab[i]+w*ac[i] for i in range(3))
for frame in [int(word) for word in sys.argv[3:]] or [-1]:
    pos={n:last(n,frame) for n in docs}
    d0s=[];ds=[]
    for n,d in docs.items():
        held=set(x for a in d['attachments'] for x in a['vertices'])
        t={}
        for e in d['externals']:
            if e['target'] not in docs: continue
            for v,dist in zip(e['vertices'],e['distances']): t.setdefault(v,[]).append((abs(dist),e['target']))
        for v,l in t.items():
            if v in held: continue
            best=9
            for _,target in l:
                tri=docs[target]['mesh']['triangles']; P=pos[target]; p=pos[n][v]
                for i in range(0,len(tri),3):
                    q=closest(p,P[tri[i]],P[tri[i+1]],P[tri[i+2]]); best=min(best,math.dist(p,q))
            d0s.append(min(l)[0]); ds.append(best)
    m0=sum(d0s)/len(d0s); print('%d vertices slide %.3f mm from their targets in the mean, %.3f at rest; each has changed by %.1f %% of that in the mean' % (
        len(ds), 1e3 * sum(ds) / len(ds), 1e3 * m0, 100 * sum(abs(a - b) for a, b in zip(ds, d0s)) / len(ds) / m0))
