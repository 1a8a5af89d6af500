import re,subprocess
files=subprocess.check_output("grep -rlE 'RenderSettings \\{' --include=*.rs shared coordinator worker scenes tests cli",shell=True,text=True).split()
for p in files:
    if p.startswith('shared/') : continue
    s=open(p).read()
    t=re.sub(r"(RenderSettings \{[^{}]*?\n(\s*)first_frame(?:: [^,\n]*)?,)(\n)(?!\s*stop)",lambda m: m.group(1)+"\n"+m.group(2)+"stop: shearwater_shared::stop::Stop::NONE,"+m.group(3),s)
    if t!=s: 
        open(p,'w').write(t); print(p)
