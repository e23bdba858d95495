# What Romeo et al. (2018) show of a body, on this one, all muscles tied to each other and to an envelope over the bones: a part of the
# Makefile beside it, whose settings hold here too. Everything goes to tied/.
#
#   make ... skeleton    skeleton.envelope.json: one surface of about 10,700 triangles over the bones, bound to them (fig. 8)
#   ... candidates       rigs/candidates: every rig with its candidates for external constraints (fig. 11)
#   ... walk, run        tied/walk.*, tied/run.*: scene, frames, log, report, pictures from three sides (figs 9 and 18)
#   ... bend             the elbows bend: distances alone, contraction, contraction with a volume gain of 1.3 (fig. 10)
#   ... torsion, shake   the forearms turn by 150 degrees; the arms are shaken, then rest
#   ... gains            at rest, and active with volume gains of 1.0, 1.3, 1.5 and 2.0, from front and back (fig. 17)
#   ... types            a planar, a fusiform and a pennate muscle: structure and fibres; the structures of all (figs 12 to 14)
#   ... charts           activation, stiffness and volume of CHARTED muscles over the walk
#   ... romeo            the walk as the paper solves it: --scheme romeo, one step a frame, 10 iterations
#
#   RUN=FILE             the run, as MOTION
#   RATE=HZ              frames a second: 60; X_FRAMES=A:B of a motion X at that rate
#   CANDIDATE_OPTIONS=   of attach-detect: --reach 6mm --targets 1 --weights rule
#   PREROLL=             of scene-build, where a motion begins away from rest
#   TIED_OPTIONS=        options of simulate for all of them but romeo: --iterations 20
#   ARMS=PATTERNS        muscles that act where arms move; the others stand aside (enabled: false)
#   TORSION_STIFFNESS=X  of external constraints where forearms turn, over that of the muscles' edges: 0.3 (default: 10)
#   CHARTED=NAMES        muscles of the chart

RUN ?= $(DATA)/mocap-cmu/motion/cmu_02_03_run.bvh
RATE ?= 60
PREROLL ?= --preroll 1.5 --run-in 1.2
TIED_OPTIONS ?= --iterations 20
WALK_FRAMES ?= 0:119
RUN_FRAMES ?= 0:85
BEND_FRAMES ?= 0:90
TORSION_FRAMES ?= 0:90
SHAKE_FRAMES ?= 0:180
GAIN_FRAMES ?= 0:30
ROMEO_FRAMES ?= $(WALK_FRAMES)
ROMEO_OPTIONS ?= --scheme romeo --substeps 1 --iterations 10
CHARTED ?= FJ443_Long_head_of_left_biceps_brachii FJ415_Left_vastus_medialis FJ834_Left_soleus FJ604_Long_head_of_left_biceps_femoris
TORSION_STIFFNESS ?= 0.3
ARMS ?= *_brachii *_*brachialis *_carpi_* *_digitorum_profundus *_palmaris_longus *_abductor_pollicis_longus *_deltoid *_teres_* \
    *_infraspinatus *_supraspinatus *_subscapularis

tied_moves := walk run bend-distances bend-contraction bend-gain torsion shake rest gain-100 gain-130 gain-150 gain-200
.PHONY: skeleton candidates walk run bend torsion shake gains types charts romeo tied-clean
skeleton: skeleton.envelope.json
candidates: candidates.sum

comma := ,
empty :=
space := $(empty) $(empty)
arms := $(filter $(notdir $(basename $(wildcard $(ARMS:%=$(meshes)/%.obj)))),$(names))

# ---- the envelope: the bones as one surface, in metres; its triangles are what candidates lie on ------------------------------------------
bones.ply: walk.motion.json
	$(tools)envelope-bind --bones $< --write-bones $@
skeleton.muscle.json: bones.ply
	$(tools)mesh-clean $< --units m --wrap 0.0014 --keep all --smooth 1 --triangles 10700 --flip-slivers --report skeleton.clean.json -o $@
skeleton.envelope.json: skeleton.muscle.json walk.motion.json
	$(tools)envelope-bind $< --bones walk.motion.json --reach 53mm --report skeleton.report.json -o $@

# ---- candidates: what faces a vertex within reach, another muscle or the envelope; a checksum is what scenes go by ---------------------------
candidates.sum: rigs.sum options.tsv skeleton.muscle.json FORCE
	+@$(MAKE) --no-print-directory -f $(here)../../make/sinew.mk $(sinew) candidates
	@cksum $(names:%=rigs/candidates/%.muscle.json) > $@.new
	@if cmp -s $@.new $@; then rm $@.new; else mv $@.new $@; fi

# ---- motions and activations ------------------------------------------------------------------------------------------------------------
run.recorded.json: $(RUN)
	$(tools)motion-import $< -o $@
run.motion.json: run.recorded.json $(table) bones.txt $(bones:%=$(meshes)/%)
	$(tools)motion-fit $< --body $(table) --bones bones.txt -o $@
joints.tsv: recorded.motion.json $(table) bones.txt
	$(tools)motion-fit -q $< --body $(table) --bones bones.txt --list > $@
bend.motion.json torsion.motion.json shake.motion.json: %.motion.json: joints.tsv $(table) bones-mm.txt $(here)arms.awk $(other_bones:%=bones-mm/%)
	awk -v motion=$* -v rate=$(RATE) -f $(here)arms.awk joints.tsv $(table) bones-mm.txt > $@
run.activation.json bend.activation.json: %.activation.json: %.motion.json $(here)bp3d.sensors.json names.txt
	$(tools)motion-sense $< --sensors $(here)bp3d.sensors.json --muscles names.txt --report $*.sensors.json -o $@

# ---- scenes ------------------------------------------------------------------------------------------------------------------------------
# $(call tied_scene,NAME,MOTION,FRAMES,OPTIONS,OTHER FILES,EXTERNALS): on MOTION.motion.json, or without one at rest; EXTERNALS are members of the
# scene's externals, a word each. Where forearms turn, nothing holds tendons at their neighbours, and what slides is softer: the tendon of
# the biceps goes around the radius.
define tied_scene
tied/$1.scene.json: candidates.sum skeleton.envelope.json $(if $2,$2.motion.json,bones-mm.txt) $5 $(lastword $(MAKEFILE_LIST)) tied.settings
	@mkdir -p $$(@D)
	$(tools)scene-build rigs/candidates $(if $2,--motion $2.motion.json,--bones bones-mm.txt --units mm) --envelope skeleton=skeleton.envelope.json \
	    --externals --rate $(RATE) --frames $3 $4 --report tied/$1.built.json -o $$@
	$(if $6,sed -i 's/"externals": true/"externals": { $(subst $(space),$(comma) ,$6) }/' $$@ && grep -q '"externals": {' $$@)
endef
only_arms = $(if $(arms),--set '*.enabled=false' $(arms:%=--set '%.enabled=true'))
active = --set '*.contraction=0.1' --set '*.law=isochoric' --set '*.activation={"keys": [[0, 0], [0.4, 1]], "interpolation": "smooth"}'
softly = "soft":false "stiffness":$(TORSION_STIFFNESS)
tied.settings: FORCE
	$(call lines,$(foreach setting,RATE PREROLL ARMS TORSION_STIFFNESS TIED_OPTIONS ROMEO_OPTIONS,$(call quoted,$(setting)=$($(setting)))))
$(eval $(call tied_scene,walk,walk,$(WALK_FRAMES),--activation walk.activation.json $(PREROLL),walk.activation.json))
$(eval $(call tied_scene,run,run,$(RUN_FRAMES),--activation run.activation.json $(PREROLL),run.activation.json))
$(eval $(call tied_scene,bend-distances,bend,$(BEND_FRAMES),$(only_arms)))
$(eval $(call tied_scene,bend-contraction,bend,$(BEND_FRAMES),$(only_arms) --activation bend.activation.json,bend.activation.json))
$(eval $(call tied_scene,bend-gain,bend,$(BEND_FRAMES),$(only_arms) --activation bend.activation.json --set '*.volumeRatio=1.3',bend.activation.json))
$(eval $(call tied_scene,torsion,torsion,$(TORSION_FRAMES),$(only_arms),,$(softly)))
$(eval $(call tied_scene,shake,shake,$(SHAKE_FRAMES),$(only_arms)))
$(eval $(call tied_scene,rest,,0:0))
$(foreach percent,100 130 150 200,$(eval $(call tied_scene,gain-$(percent),,$(GAIN_FRAMES),$(active) --set '*.volumeRatio=$(percent)e-2')))

# ---- simulations: status 3 goes on, and the pictures say so ---------------------------------------------------------------------------------
# $(call simulated,NAME,OPTIONS) as the recipe of tied/NAME.jsonl, from $<
define simulated
@rm -rf tied/$1 tied/$1.status tied/$1.state
$(tools)simulate $< -o tied/$1 $2 --log $@ --report tied/$1.report.json --state tied/$1.state 2> tied/$1.said; status=$$?; echo $$status > tied/$1.status; \
    grep -v -e '^simulate: warning: muscle' tied/$1.said || :; [ $$status -eq 0 ] || [ $$status -eq 3 ]
endef
$(tied_moves:%=tied/%.jsonl): tied/%.jsonl: tied/%.scene.json
	$(call simulated,$*,$(TIED_OPTIONS))
tied/romeo.jsonl: tied/walk.scene.json
	$(call simulated,romeo,$(ROMEO_OPTIONS) --frames $(ROMEO_FRAMES))

# ---- pictures ------------------------------------------------------------------------------------------------------------------------------
sheet := TOOLS=$(tools:%/=%) sh $(here)sheet.sh
# frames have one camera: from the side the way is wider than the body is high
tiles = --camera $1 $(if $(filter left right,$1),--columns 1 --size 1600x640,--columns 4 --size 480x800)
tied/walk.%.png: tied/walk.jsonl
	$(sheet) tied/walk 4 "The walk" $(call tiles,$*) -o $@
tied/run.%.png: tied/run.jsonl
	$(sheet) tied/run 4 "The run" $(call tiles,$*) -o $@
tied/romeo.%.png: tied/romeo.jsonl
	SCENE=tied/walk.scene.json $(sheet) tied/romeo 4 "The walk by --scheme romeo" $(call tiles,$*) -o $@
tied/bend-distances.png tied/bend-contraction.png tied/bend-gain.png tied/torsion.png tied/shake.png: tied/%.png: tied/%.jsonl
	$(sheet) tied/$* 4 "$*" --camera 60:5 --focus '$(subst $(space),$(comma),$(or $(filter %_Left_brachialis %_left_biceps_brachii %_Left_flexor_% %_left_flexor_carpi_ulnaris,$(arms)),$(arms)))' --columns 4 --size 420x640 -o $@
tied/%-front.png: tied/%.jsonl
	$(sheet) tied/$* 1 "$*" --camera front --size 400x900 -o $@
tied/%-back.png: tied/%.jsonl
	$(sheet) tied/$* 1 "$*" --camera back --size 400x900 -o $@

# ---- muscles of three types; the structures of all ------------------------------------------------------------------------------------------
types := $(foreach type,*_Sternocostal_part_of_left_pectoralis_major *_Long_head_of_left_biceps_brachii *_Left_rectus_femoris,$(filter $(notdir $(basename $(wildcard $(type:%=$(meshes)/%.obj)))),$(names)))
tied/structures.png: rigs.sum
	@mkdir -p $(@D)
	$(tools)rig-view -q $(types:%=rigs/%.muscle.json) --show surface,roots,structure --columns 3 --size 360x640 --title "A planar, a fusiform and a pennate muscle: structure" -o $@
tied/fibres.png: rigs.sum
	@mkdir -p $(@D)
	$(tools)rig-view -q $(types:%=rigs/%.muscle.json) --show surface,roots,fibers --columns 3 --size 360x640 --title "A planar, a fusiform and a pennate muscle: fibres" -o $@
# a state is drawn with its internal edges: at rest none is off its length
tied/all-structures.png: tied/rest.jsonl
	$(tools)rig-view -q tied/rest.scene.json --state tied/rest.state --error internal --range 1 --views front,back --columns 2 --size 640x1100 \
	    --title "The structures of $(words $(names)) muscles" -o $@

# ---- the chart: a panel a quantity, a line a muscle ------------------------------------------------------------------------------------------
tied/chart.tsv: tied/walk.jsonl $(here)chart.awk
	awk -v names="$(filter $(CHARTED),$(names))" -f $(here)chart.awk $< > $@
tied/chart.svg tied/chart.png: tied/chart.tsv $(here)chart.gp
	gnuplot -e "table='$<'; picture='$@'; kind='$(patsubst .%,%,$(suffix $@))'" $(here)chart.gp

# ---- what there is to ask for ------------------------------------------------------------------------------------------------------------------
walk: $(PICTURES:%=tied/walk.%.png)
run: $(PICTURES:%=tied/run.%.png)
bend: tied/bend-distances.png tied/bend-contraction.png tied/bend-gain.png
torsion: tied/torsion.png
shake: tied/shake.png
gains: $(foreach side,front back,tied/rest-$(side).png $(foreach percent,100 130 150 200,tied/gain-$(percent)-$(side).png))
types: tied/structures.png tied/fibres.png tied/all-structures.png
charts: tied/chart.svg tied/chart.png
romeo: $(PICTURES:%=tied/romeo.%.png)
tied-clean:
	rm -rf tied candidates.sum skeleton.* bones.ply joints.tsv run.*.json bend.*.json torsion.*.json shake.*.json tied.settings
