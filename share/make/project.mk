# Targets around the build: dependencies, tests, demo, installation. Included by the Makefile.

JOBS ?= $(shell nproc)
STAMPS := $(B)/checked
PACKAGES := share/debian-packages.txt

deps:
	@share/make/install-packages $(PACKAGES)

clean:
	rm -rf build

# ---- tests: a suite runs again only when something it depends on has changed ------------------------------------------------
CLI_SUITES := $(sort $(wildcard tests/cli/*.bats))
UNIT_STAMPS := $(UNIT_TESTS:$(B)/tests/unit/%=$(STAMPS)/unit-%)
CLI_STAMPS := $(CLI_SUITES:tests/cli/%.bats=$(STAMPS)/cli-%)
PROGRAM_STAMPS := $(patsubst tests/%.c,$(STAMPS)/program-%,$(sort $(wildcard tests/fuzz/*.c tests/numerics/*.c)))
SHORT_STAMPS := $(STAMPS)/layering $(STAMPS)/circles $(STAMPS)/parameters $(STAMPS)/man-schema $(UNIT_STAMPS) $(CLI_STAMPS)
ALL_STAMPS := $(SHORT_STAMPS) $(PROGRAM_STAMPS) $(STAMPS)/examples $(STAMPS)/anatomy $(STAMPS)/install
ASSETS := $(wildcard share/make/sinew.mk share/make/assets share/make/*.awk)
EVERYTHING := $(ASSETS) $(wildcard share/plots/* share/examples/arm/* share/examples/body/* share/examples/assets/* share/examples/papers/* share/examples/hip/* share/examples/leg/* share/examples/sensors/* share/completions/*) $(BUILT_TOOLS) $(BUILT_LIBEXEC) $(EXAMPLES) $(wildcard share/schema/*.json) tests/suite

# the first make may install the compiler's libraries: build in a second one
check: deps
	@$(MAKE) --no-print-directory -j$(JOBS) programs examples tests
	@$(MAKE) --no-print-directory -k -j$(JOBS) --output-sync=target suites || true
	@tests/sum $(ALL_STAMPS)
check-short: deps
	@$(MAKE) --no-print-directory -j$(JOBS) programs examples $(UNIT_TESTS)
	@$(MAKE) --no-print-directory -k -j$(JOBS) --output-sync=target short-suites || true
	@tests/sum $(SHORT_STAMPS)
.PHONY: suites short-suites check-short examples
examples: $(EXAMPLES)
suites: $(ALL_STAMPS)
short-suites: $(SHORT_STAMPS)

$(STAMPS)/layering: tests/layering $(wildcard include/sinew/*.h lib/*/*.[ch] lib/*/*.cpp tools/*.[ch])
	@tests/suite $@ layering tests/layering
$(STAMPS)/circles: tests/circles $(B)/libsinew.a
	@tests/suite $@ circles tests/circles $(addprefix $(B)/lib/,base geom motion sim view)
$(STAMPS)/parameters: tests/parameters $(wildcard include/sinew/*.h lib/*/*.[ch] lib/*/*.hpp lib/*/*.cpp tools/*.[ch])
	@tests/suite $@ parameters tests/parameters
$(STAMPS)/man-schema: tests/man-schema $(wildcard share/man/*.5 share/schema/*.json)
	@tests/suite $@ man-schema tests/man-schema share/man share/schema
$(UNIT_STAMPS): $(STAMPS)/unit-%: $(B)/tests/unit/%
	@DATA=$(DATA) tests/suite $@ unit/$* $<
$(STAMPS)/program-numerics/sim_golden: tests/data/golden.txt
$(PROGRAM_STAMPS): $(STAMPS)/program-%: $(B)/tests/%
	@DATA=$(DATA) tests/suite $@ $* $<
$(CLI_STAMPS): $(STAMPS)/cli-%: tests/cli/%.bats $(EVERYTHING)
	@BIN=$(CURDIR)/$(B)/bin EXAMPLES=$(CURDIR)/$(B)/examples DATA=$(abspath $(DATA)) CONFIG=$(CONFIG) tests/suite $@ cli/$* bats --tap $<
$(STAMPS)/cli-make: Makefile share/make/project.mk share/make/install-packages tests/sum
$(STAMPS)/cli-fiber-fill: tests/ward-table
$(STAMPS)/cli-papers: tests/kohout-table $(B)/tests/numerics/hinge_rules
$(STAMPS)/examples: tests/run-man-examples tests/sample-folder README.md $(wildcard share/man/*.[157]) $(EVERYTHING)
	@tests/suite $@ examples tests/run-man-examples $(B)/bin $(B)/examples
$(STAMPS)/anatomy: tests/anatomy $(EVERYTHING)
	@tests/suite $@ anatomy tests/anatomy $(B)/bin $(DATA) $(B)/anatomy
$(STAMPS)/install: tests/install $(EVERYTHING) $(B)/libsinew.a
	@tests/suite $@ install tests/install $(CONFIG)

# ---- the solver's instruments: none of them runs in check ----------------------------------------------------------------------
# what it takes to start a tool, and to rig a muscle
.PHONY: start-up rig-time motion-time body-walk bodies coupled dog-trot
start-up: $(BUILT_TOOLS)
	@BIN=$(B)/bin tests/bench/start-up.sh
rig-time: $(BUILT_TOOLS)
	@BIN=$(B)/bin DATA=$(DATA) tests/bench/rig-time.sh
# what it takes to import a recorded walk, and to fit it to a body; to bind an envelope and to move it
motion-time: $(BUILT_TOOLS) $(B)/tests/bench/envelope_deform
	@BIN=$(B)/bin DATA=$(DATA) tests/bench/motion-time.sh
	@BIN=$(B)/bin DATA=$(DATA) tests/bench/fit-time.sh
	@BIN=$(B)/bin DATA=$(DATA) tests/bench/envelope-time.sh
# 148 muscles of a body, from surfaces to 120 frames of a walk: what they lack, and what they take
body-walk: $(BUILT_TOOLS)
	@BIN=$(B)/bin DATA=$(DATA) tests/bench/body-walk.sh $(B)/body-walk
# the same body tied to an envelope over its bones and to itself: every motion and picture of Romeo et al. (2018), and what it takes, in one folder
bodies: $(BUILT_TOOLS)
	@BIN=$(B)/bin DATA=$(DATA) tests/bench/bodies.sh $(B)/bodies
# twelve muscles of a dog's hind leg and of its fore leg that are tied to each other: time and error by iterations
coupled: $(BUILT_TOOLS)
	@BIN=$(B)/bin DATA=$(DATA) tests/bench/coupled.sh $(B)/coupled
# all 253 muscles of a dog, tied to each other, through a second of its trot, on one thread and on two: ten minutes or more
dog-trot: $(BUILT_TOOLS)
	@BIN=$(B)/bin DATA=$(DATA) tests/bench/dog-trot.sh $(B)/dog-trot
# what it takes to build the distance fields of the leg's bones, and to ask them; and 25 bones against brute force, ten minutes or more
.PHONY: field-time field-anatomy
field-time: $(B)/tests/bench/distance_field
	@DATA=$(DATA) $<
field-anatomy: $(B)/tests/numerics/field_anatomy
	@DATA=$(DATA) $< 12000
# the repair of every defective mesh at hand, as a table; and how time and memory of mesh-clean grow
.PHONY: repair-table clean-growth
repair-table: $(BUILT_TOOLS)
	@tests/repair-table $(B)/bin $(DATA) $(B)/repair-table
clean-growth: $(BUILT_TOOLS) $(B)/examples/arm/arm
	@BIN=$(B)/bin EXAMPLES=$(B)/examples tests/bench/clean-growth.sh

.PHONY: bench bench-body golden golden-accept stability off-equals-absent
bench: $(B)/tests/bench/sim_rows $(B)/tests/bench/embedding
	$<
	$(B)/tests/bench/embedding
bench-body: $(B)/tests/bench/sim_body
	$<
golden:
	tests/golden $(BUILDS)
# a change that is meant to change bits says so by committing these
golden-accept: $(B)/tests/numerics/sim_golden
	$< --hashes 1 > $(B)/golden.log
	sed -n 's/^hash //p' $(B)/golden.log > tests/data/golden.txt
	-git --no-pager diff --stat -- tests/data/golden.txt
stability: programs $(B)/tests/numerics/sim_extremes
	tests/stability $(B)/bin $(B)/tests/numerics/sim_extremes $(DATA) $(B)/stability
# fibre lengths of rigs of a leg against those that Ward et al. (2009) measured
.PHONY: ward-table
ward-table: $(BUILT_TOOLS)
	@tests/ward-table $(B)/bin $(DATA) $(B)/ward-table
# the scheme kohout at its paper's setting: what is left of the arm's muscles and of two of the leg, by hinges and iterations
.PHONY: kohout-table
kohout-table: programs examples $(B)/tests/numerics/hinge_rules
	@tests/kohout-table $(B)/bin $(B)/tests/numerics/hinge_rules $(B)/examples $(DATA) $(B)/kohout-table
# error against run time: the charts of share/doc, and what they are made of
.PHONY: error-time-charts
error-time-charts: programs examples
	share/examples/tip/charts.sh $(B)/bin $(B)/examples/tip/tip $(DATA) $(B)/charts
# the experiments of the papers, whole: figures, charts and tables in one folder with an index, about 20 minutes
.PHONY: papers
papers: programs examples
	@PATH=$(CURDIR)/$(B)/bin:$$PATH EXAMPLES=$(CURDIR)/$(B)/examples share/examples/papers/papers.sh $(PAPERS_OPTIONS) $(DATA) $(B)/papers
off-equals-absent: programs examples
	tests/off-equals-absent $(B)/bin $(B)/examples

# every row of the study of rig generation, on every muscle (check runs a short form)
anatomy: $(B)/tests/numerics/anatomy_rig $(B)/tests/numerics/attach_rules $(B)/tests/numerics/fill_anatomy $(B)/tests/numerics/fill_areas $(B)/tests/numerics/fill_shape
	DATA=$(DATA) $(B)/tests/numerics/anatomy_rig --all
	DATA=$(DATA) $(B)/tests/numerics/attach_rules --all
	DATA=$(DATA) $(B)/tests/numerics/fill_anatomy all
	DATA=$(DATA) $(B)/tests/numerics/fill_areas all
	DATA=$(DATA) $(B)/tests/numerics/fill_shape all
.PHONY: anatomy

# ---- demo ---------------------------------------------------------------------------------------------------------------------
demo: deps
	@$(MAKE) --no-print-directory -j$(JOBS) programs examples
	@share/examples/arm/demo.sh $(B)/bin $(B)/examples build/demo
# how far the arm's passive biceps folds, without and with tone: the table and the picture of simulate(1)
.PHONY: tone
tone: deps
	@$(MAKE) --no-print-directory -j$(JOBS) programs examples
	@mkdir -p build/tone
	@$(MAKE) -s --no-print-directory -C build/tone -f $(CURDIR)/share/examples/arm/Makefile TOOLS=$(CURDIR)/$(B)/bin ARM=$(CURDIR)/$(B)/examples/arm/arm tone

# ---- checks of the sources ------------------------------------------------------------------------------------------------------
C_FILES := $(wildcard include/sinew/*.h lib/*/*.[ch] tools/*.[ch] tests/*/*.c share/examples/*/*.c)
format:
	clang-format -i $(C_FILES)
layering:
	tests/layering
lint:
	clang-tidy --quiet $(LIB_SOURCES) $(wildcard tools/*.c) -- $(CPPFLAGS_ALL) -std=c17
	cppcheck --quiet --enable=warning,performance,portability --inline-suppr --error-exitcode=1 -Iinclude -Itools lib tools

# ---- completions: made from what each tool's --help says ------------------------------------------------------------------------
COMPLETIONS := $(foreach s,bash zsh fish,$(BUILT_TOOLS:$(B)/bin/%=$(B)/completions/$s/%))
.PHONY: completions
all: completions
completions: $(COMPLETIONS)
define completion_rule
$(B)/completions/$1/%: $(B)/bin/% share/completions/generate share/completions/generate.awk
	@mkdir -p $$(@D)
	$$(call say,GEN,$$@)
	$$(Q)$$< --help | share/completions/generate $1 $$* > $$@
endef
$(foreach s,bash zsh fish,$(eval $(call completion_rule,$s)))

# ---- installation ---------------------------------------------------------------------------------------------------------------
define PKG_CONFIG
prefix=$(PREFIX)
libdir=$${prefix}/lib
includedir=$${prefix}/include
makefile=$${prefix}/share/sinew/make/sinew.mk

Name: sinew
Description: Muscle rigs from surface meshes, and their simulation
Version: $(VERSION)
Cflags: -I$${includedir}
Libs: -L$${libdir} -lsinew
Libs.private: $(sort $(foreach l,cgal embree sparse gsl mesh json png exact,$(LINK_$l))) -lm -pthread
endef
export PKG_CONFIG

D = $(DESTDIR)$(PREFIX)
EXAMPLE_FOLDERS := arm body assets hip leg papers sensors tip
COMPLETION_FOLDERS := bash-completion/completions zsh/site-functions fish/vendor_completions.d
install: programs examples completions
	install -d $D/bin $D/libexec/sinew $D/lib/pkgconfig $D/include/sinew $D/share/man/man1 $D/share/man/man5 $D/share/man/man7 $(COMPLETION_FOLDERS:%=$D/share/%)
	install -d $(addprefix $D/share/sinew/,schema make plots $(EXAMPLE_FOLDERS:%=examples/%))
	install -m 755 $(BUILT_TOOLS) $D/bin
	install -m 755 $(BUILT_LIBEXEC) $(EXAMPLES) $D/libexec/sinew
	install -m 644 $(B)/libsinew.a $D/lib
	install -m 644 $(wildcard include/sinew/*.h) $D/include/sinew
	install -m 644 $(wildcard share/man/*.1) $D/share/man/man1
	install -m 644 $(wildcard share/man/*.5) $D/share/man/man5
	install -m 644 $(wildcard share/man/*.7) $D/share/man/man7
	install -m 644 $(wildcard share/schema/*.json) $D/share/sinew/schema
	install -m 644 $(ASSETS) $D/share/sinew/make
	install -m 644 $(wildcard share/plots/*.gp) $D/share/sinew/plots
	install -m 755 $(filter-out %.gp,$(wildcard share/plots/*)) $D/share/sinew/plots
	for e in $(EXAMPLE_FOLDERS); do cp share/examples/$$e/* $D/share/sinew/examples/$$e || exit 1; done
	install -m 644 $(B)/completions/bash/* $D/share/bash-completion/completions
	for t in $(notdir $(BUILT_TOOLS)); do \
	    install -m 644 $(B)/completions/zsh/$$t $D/share/zsh/site-functions/_$$t && \
	    install -m 644 $(B)/completions/fish/$$t $D/share/fish/vendor_completions.d/$$t.fish || exit 1; done
	@echo "$$PKG_CONFIG" > $D/lib/pkgconfig/sinew.pc
uninstall:
	rm -f $(BUILT_TOOLS:$(B)/bin/%=$D/bin/%) $D/lib/libsinew.a $D/lib/pkgconfig/sinew.pc
	rm -rf $D/libexec/sinew $D/include/sinew $D/share/sinew
	rm -f $(patsubst share/man/%,$D/share/man/man1/%,$(wildcard share/man/*.1)) $(patsubst share/man/%,$D/share/man/man5/%,$(wildcard share/man/*.5)) \
	    $(patsubst share/man/%,$D/share/man/man7/%,$(wildcard share/man/*.7))
	rm -f $(foreach t,$(notdir $(BUILT_TOOLS)),$D/share/bash-completion/completions/$t $D/share/zsh/site-functions/_$t \
	    $D/share/fish/vendor_completions.d/$t.fish)
