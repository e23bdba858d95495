# sinew.mk: from a folder of surfaces and a table of options to rigs. For a Makefile to include, or by itself; sinew-make(7) tells more.
#
#   SINEW_SURFACES = muscles            a folder, FOLDER/PATTERN, or a text file with a surface a line: FILE, or NAME, a tab and FILE
#   SINEW_BONES    = bones              the same for the bones; empty: rigs without attachments
#   SINEW_TABLE    = options.tsv        muscle, tool, options, separated by tabs; names may hold * and ?
#   include /usr/local/share/sinew/make/sinew.mk
#
#   make [-jN]      every rig, $(SINEW_OUT)/NAME.muscle.json, then summary.tsv and contact sheets beside them
#   make rigs       the rigs alone; a muscle that fails ends it, unless with -k
#   make candidates the rigs with candidates for external constraints, $(SINEW_OUT)/candidates/NAME.muscle.json, and candidates.tsv
#   make architecture   the rigs with fibres through them, $(SINEW_OUT)/architecture/NAME.muscle.json, and architecture.tsv
#   make lint       what is wrong with every surface and bone: lint.tsv, and contact sheets of the defective ones
#
# A stage is run again when its input, its options or its tool's version has changed. X.done says when X was last made, X keeps its
# time stamp when it came out with the same bytes: what depends on X is then left alone.

SINEW_SURFACES ?= muscles
SINEW_BONES ?=
SINEW_TABLE ?=
# units and up axis of the bare meshes; empty: as the tools take them
SINEW_UNITS ?=
SINEW_UP ?=
SINEW_BONE_UNITS ?=
SINEW_BONE_UP ?=
# fibres through the volume of every muscle; empty: of those alone to which the table gives options of fiber-fill
SINEW_FIBERS ?=
# rigs, logs and stages go here
SINEW_OUT ?= rigs
# the folder of the tools; empty: they are on the PATH
SINEW_BIN ?=
# threads of one tool; make -j runs several tools at once
SINEW_THREADS ?= 1
# muscles on a page of a contact sheet, and pixels of each
SINEW_PAGE ?= 100
SINEW_PIXELS ?= 240x180
SINEW_LINT ?= --self-intersections

sinew_settings := SINEW_SURFACES SINEW_BONES SINEW_TABLE SINEW_UNITS SINEW_UP SINEW_BONE_UNITS SINEW_BONE_UP SINEW_FIBERS SINEW_OUT SINEW_BIN \
    SINEW_THREADS SINEW_PAGE SINEW_PIXELS SINEW_LINT
export $(sinew_settings)

sinew_makefile := $(firstword $(MAKEFILE_LIST))
sinew_here := $(dir $(lastword $(MAKEFILE_LIST)))
ifeq ($(wildcard $(sinew_here)assets),)
$(error sinew.mk: its folder has a space in its path, or lacks the program 'assets'; install sinew where the path has no space)
endif
ifeq ($(wildcard $(sinew_makefile)),)
$(error sinew.mk: a Makefile whose path has a space cannot be found again; change to its folder and call make there)
endif
sinew_assets := sh $(sinew_here)assets
sinew_quote = '$(subst ','\'',$1)'

# ---- what there is: names, links, options and extra dependencies, written to state/ by every make ------------------------------
# A make that a rule of this one calls works in the folder that this one has locked.
ifndef SINEW_LISTED
ifeq ($(filter $(abspath $(SINEW_OUT)),$(SINEW_LOCKED)),)
sinew_said := $(shell $(foreach s,$(sinew_settings),$(s)=$(call sinew_quote,$($(s)))) $(sinew_assets) lock $$PPID)
ifneq ($(.SHELLSTATUS),0)
$(error stopped before any work)
endif
export SINEW_LOCKED := $(SINEW_LOCKED) $(abspath $(SINEW_OUT))
endif
sinew_said := $(shell $(foreach s,$(sinew_settings),$(s)=$(call sinew_quote,$($(s)))) $(sinew_assets) list)
ifneq ($(.SHELLSTATUS),0)
$(error stopped before any work)
endif
sinew_said := $(foreach g,$(filter rigs lint,$(MAKECMDGOALS)),$(shell $(foreach s,$(sinew_settings),$(s)=$(call sinew_quote,$($(s)))) $(sinew_assets) plan $g))
endif
sinew_state := $(SINEW_OUT)/state
sinew_stages := $(SINEW_OUT)/stages

.PHONY: assets rigs summary lint candidates candidate-documents architecture architecture-documents assets-clean
assets:
	@$(sinew_assets) plan rigs
	@$(MAKE) -k --no-print-directory -f $(sinew_makefile) SINEW_LISTED=yes rigs || true
	@$(sinew_assets) sheets rigs
	@$(sinew_assets) summary

include $(sinew_state)/assets.mk

# ---- the chain --------------------------------------------------------------------------------------------------------------------
rigs: $(sinew_names:%=$(SINEW_OUT)/%.muscle.json)
	@:

# $(call sinew_stage,TOOL,SUFFIX,DOCUMENT BEFORE,DOCUMENT AFTER), names of documents with % for the muscle
define sinew_stage
$(sinew_names:%=$(sinew_stages)/%.$2.done): $(sinew_stages)/%.$2.done: $3 $(sinew_state)/options/%.$1 $(sinew_state)/tools/$1
	@$(sinew_assets) stage $1 $2 $$* $$(or $$(filter $(sinew_state)/in/%,$$^),$$<)
$(sinew_names:%=$4): $4: $(sinew_stages)/%.$2.done
	@test -e $$@ || { rm -f $$<; $$(MAKE) --no-print-directory -f $(sinew_makefile) SINEW_LISTED=yes $$<; }
endef
$(eval $(call sinew_stage,mesh-clean,clean,,$(sinew_stages)/%.clean.json))
$(eval $(call sinew_stage,attach-detect,attached,$(sinew_stages)/%.clean.json,$(sinew_stages)/%.attached.json))
$(eval $(call sinew_stage,root-select,roots,$(sinew_stages)/%.attached.json,$(sinew_stages)/%.roots.json))
$(eval $(call sinew_stage,build-structure,structure,$(sinew_stages)/%.roots.json,$(sinew_stages)/%.structure.json))
$(eval $(call sinew_stage,fiber-flow,fibers,$(sinew_stages)/%.structure.json,$(sinew_stages)/%.fibers.json))
$(eval $(call sinew_stage,fiber-fill,muscle,$(sinew_stages)/%.fibers.json,$(SINEW_OUT)/%.muscle.json))

# a bone's checksum: a touched bone with the same bytes changes nothing
$(sinew_bones:%=$(sinew_state)/bones/%.done): $(sinew_state)/bones/%.done:
	@$(sinew_assets) bone $* $<
$(sinew_bones:%=$(sinew_state)/bones/%.sum): $(sinew_state)/bones/%.sum: $(sinew_state)/bones/%.done ;
$(sinew_state)/all.done: $(sinew_bones:%=$(sinew_state)/bones/%.sum) $(sinew_state)/all.bones
	@$(sinew_assets) all-bones
$(sinew_state)/all.sum: $(sinew_state)/all.done ;

summary:
	@$(sinew_assets) summary

# ---- candidates for external constraints: which rigs are near which is known once they are there; so in a make of its own ------------
candidates:
	@$(sinew_assets) plan rigs
	@$(MAKE) -k --no-print-directory -f $(sinew_makefile) SINEW_LISTED=yes rigs || true
	@$(sinew_assets) near
	@$(sinew_assets) plan candidates
	@$(MAKE) -k --no-print-directory -f $(sinew_makefile) SINEW_LISTED=yes candidate-documents || true
	@$(sinew_assets) candidate-table

sinew_near := $(filter $(sinew_names),$(notdir $(wildcard $(sinew_state)/near/*)))
candidate-documents: $(sinew_near:%=$(SINEW_OUT)/candidates/%.muscle.json)
	@:
$(sinew_near:%=$(sinew_state)/candidates/%.done): $(sinew_state)/candidates/%.done: $(SINEW_OUT)/%.muscle.json $(sinew_state)/near/% $(sinew_state)/options/%.candidates $(sinew_state)/tools/attach-detect
	@$(sinew_assets) candidate $*
$(sinew_near:%=$(SINEW_OUT)/candidates/%.muscle.json): $(SINEW_OUT)/candidates/%.muscle.json: $(sinew_state)/candidates/%.done
	@test -e $@ || { rm -f $<; $(MAKE) --no-print-directory -f $(sinew_makefile) SINEW_LISTED=yes $<; }

# ---- architecture: fibres through every rig that is there, and what they measure ------------------------------------------------------
architecture:
	@$(sinew_assets) plan rigs
	@$(MAKE) -k --no-print-directory -f $(sinew_makefile) SINEW_LISTED=yes rigs || true
	@$(sinew_assets) forget-architecture
	@$(sinew_assets) plan architecture
	@$(MAKE) -k --no-print-directory -f $(sinew_makefile) SINEW_LISTED=yes architecture-documents || true
	@$(sinew_assets) architecture-table

sinew_rigged := $(filter $(sinew_names),$(patsubst %.muscle.json,%,$(notdir $(wildcard $(SINEW_OUT)/*.muscle.json))))
architecture-documents: $(sinew_rigged:%=$(SINEW_OUT)/architecture/%.muscle.json)
	@:
$(sinew_rigged:%=$(sinew_state)/architecture/%.done): $(sinew_state)/architecture/%.done: $(SINEW_OUT)/%.muscle.json $(sinew_state)/options/%.architecture $(sinew_state)/tools/fiber-fill
	@$(sinew_assets) architecture $*
$(sinew_rigged:%=$(SINEW_OUT)/architecture/%.muscle.json): $(SINEW_OUT)/architecture/%.muscle.json: $(sinew_state)/architecture/%.done
	@test -e $@ || { rm -f $<; $(MAKE) --no-print-directory -f $(sinew_makefile) SINEW_LISTED=yes $<; }

# ---- lint -------------------------------------------------------------------------------------------------------------------------
sinew_linted := $(sinew_names:%=$(sinew_state)/lint/surface/%.done) $(sinew_bones:%=$(sinew_state)/lint/bone/%.done)
$(sinew_linted): $(sinew_state)/lint/%.done: $(sinew_state)/lint.options $(sinew_state)/tools/mesh-clean
	@$(sinew_assets) lint $* $(filter $(sinew_state)/in/% $(sinew_state)/bones/%,$^)
lint: $(sinew_linted)
	@$(sinew_assets) sheets lint
	@$(sinew_assets) lint-table

assets-clean:
	rm -rf $(SINEW_OUT)
