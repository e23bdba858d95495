# Options for sinew.mk that attach each muscle of the dog around its sites (attachments.tsv). A site carries the vertices within 10 mm of it, or
# those nearly as near as the nearest. One that is 30 mm from its muscle is another's. Ribs, sternum, skull and jaw are merged in the meshes.
# Sites of bones that are not there are left out. Muscles without two sites are attached by what touches them.
#
#   ls bones | awk -f sites.awk - attachments.tsv > options.tsv

BEGIN { FS = "\t"; REACH = 0.010; FAR = 0.030 }
FNR == NR { sub(/\.[^.]*$/, ""); there[$0]; next }
FNR == 1 || $7 == "" || $9 > FAR { next }
{
    name = $7
    bone = $8
    sub(/\.stl$/, "", name)
    gsub(/^BONE|\.stl$/, "", bone)
    if (bone == "" && $2 ~ /^(Rib|Sternum)/) bone = "Ribcage"
    if (bone == "" && $2 ~ /^Skull/) bone = "MergedSkull"
    if (bone == "" && $2 ~ /^Mandible/) bone = "Jaw"
    if (!(bone in there)) next
    if (!(name in pins)) order[++count] = name
    reach = $9 * 1.1 > REACH ? $9 * 1.1 : REACH
    pins[name] = pins[name] " --pin " bone "=sphere:" $3 "," $4 "," $5 "," reach
    sites[name]++
}
END {
    for (i = 1; i <= count; i++)
        if (sites[order[i]] > 1) print order[i] "\tattach-detect\t--method none" pins[order[i]]
}
