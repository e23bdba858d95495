# sinew: muscle rigs from surface meshes, and their simulation.
#
#   make            build everything                 make demo      install what is missing, build, run the sample arm, draw it
#   make check      install what is missing, build, pass every test
#   make deps       install the Debian packages of share/debian-packages.txt that are missing
#   make install    PREFIX=/usr/local DESTDIR=       make fuzz      coverage-guided fuzzing of every reader (FUZZ_SECONDS=60 each)
#   V=1             print every command, not a line a file
#   CONFIG=release (default) | debug | sanitize | thread | scalar | coverage: each builds in build/$(CONFIG)

CONFIG ?= release
PREFIX ?= /usr/local
DESTDIR ?=
B := build/$(CONFIG)
BRIDGE := build/bridge
DATA ?= ../shared/data
VERSION := $(shell sed -n 's/^\#define SN_VERSION "\(.*\)"/\1/p' include/sinew/base.h)

# ---- flags ----------------------------------------------------------------------------------------------------------------
WARN := -Wall -Wextra -Wshadow -Wconversion -Wmissing-prototypes -Wstrict-prototypes -Wcast-qual -Wno-psabi
WERROR ?=
FLAGS_release  := -O2 -g -DNDEBUG
FLAGS_debug    := -O0 -g3
FLAGS_sanitize := -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer
FLAGS_thread   := -O1 -g -fsanitize=thread
FLAGS_scalar   := -O2 -g -DNDEBUG -DSN_SCALAR
FLAGS_coverage := -O0 -g --coverage
ifeq ($(FLAGS_$(CONFIG)),)
$(error CONFIG=$(CONFIG) is none of release debug sanitize thread scalar coverage)
endif
CPPFLAGS_ALL := -Iinclude -D_GNU_SOURCE $(CPPFLAGS)
CFLAGS_ALL := -std=c17 $(FLAGS_$(CONFIG)) -ffp-contract=off -fno-math-errno -pthread $(WARN) $(WERROR) $(CFLAGS)
# the bridge is built once for all configurations; CGAL is a system header: no warnings from it
BRIDGE_FLAGS := -std=c++17 -O2 -DNDEBUG -ffp-contract=off -frounding-math -Iinclude -Ilib/geom -isystem /usr/include/eigen3 -Wall -Wextra $(WERROR)

# ---- libraries, each named once; a tool links only what it lists ------------------------------------------------------------
LINK_gsl     := -lgsl -lgslcblas
LINK_exact   := -lmpfr -lgmp
LINK_json    := -ljansson -lmd
LINK_mesh    := -lexpat -lz
LINK_sparse  := -lcholmod -lamd -lcolamd -lsuitesparseconfig
LINK_embree  := -lembree3
LINK_cgal    := -lgmp -lmpfr -lstdc++
LINK_png     := -lpng -lz
LINK_assimp  := -lassimp

TOOLS := mesh-clean root-select build-structure fiber-flow fiber-fill attach-detect motion-import motion-fit motion-sense envelope-bind scene-build simulate moment-arm error-time rig-view
LIBS_mesh-clean      := cgal embree mesh json exact
LIBS_root-select     := sparse mesh json
LIBS_build-structure := embree mesh json
LIBS_fiber-flow      := sparse mesh json
LIBS_fiber-fill      := gsl sparse embree mesh json exact
LIBS_attach-detect   := embree mesh json
LIBS_motion-import   := mesh json exact
LIBS_motion-fit      := gsl embree mesh json exact
LIBS_motion-sense    := gsl mesh json exact
LIBS_scene-build     := embree mesh json exact
LIBS_envelope-bind   := gsl embree mesh json exact
LIBS_simulate        := gsl sparse embree mesh json exact
LIBS_moment-arm      := gsl mesh json exact
LIBS_rig-view        := embree gsl sparse mesh json png exact
LIBS_error-time      := gsl sparse embree mesh json exact

# run by the tools, not by hand: installed in libexec/sinew
LIBEXEC_TOOLS := mesh-import
LIBS_mesh-import     := assimp mesh json

# ---- sources ----------------------------------------------------------------------------------------------------------------
LIB_SOURCES := $(sort $(wildcard lib/*/*.c))
BRIDGE_SOURCES := $(sort $(wildcard lib/geom/cgal_*.cpp))
LIB_OBJECTS := $(LIB_SOURCES:%.c=$(B)/%.o)
BRIDGE_OBJECTS := $(BRIDGE_SOURCES:lib/geom/%.cpp=$(BRIDGE)/%.o)
TOOL_SHARED := $(patsubst %.c,$(B)/%.o,$(wildcard tools/cli.c tools/cli_files.c tools/chain.c tools/selector.c tools/bones.c tools/folder.c tools/chart.c tools/grips.c))
BUILT_TOOLS := $(foreach t,$(TOOLS),$(if $(wildcard tools/$t.c),$(B)/bin/$t))
BUILT_LIBEXEC := $(LIBEXEC_TOOLS:%=$(B)/libexec/sinew/%)
EXAMPLES := $(patsubst share/examples/%.c,$(B)/examples/%,$(wildcard share/examples/*/*.c))
UNIT_TESTS := $(patsubst tests/unit/%.c,$(B)/tests/unit/%,$(sort $(wildcard tests/unit/test_*.c)))
EXTRA_TESTS := $(patsubst tests/%.c,$(B)/tests/%,$(sort $(wildcard tests/fuzz/*.c tests/numerics/*.c tests/bench/*.c)))

# ---- what is printed: a line a file; V=1 the commands themselves, make -s nothing ---------------------------------------------
V ?= 0
Q := $(if $(filter 1,$V),,@)
say = $(if $(filter 1,$V),,$(if $(findstring s,$(firstword -$(MAKEFLAGS))),,@echo '$(1) $(2)'))

.PHONY: all deps check demo clean install uninstall lint layering format tests programs
.DELETE_ON_ERROR:
.SECONDARY:
all: programs
programs: $(BUILT_TOOLS) $(BUILT_LIBEXEC) $(B)/libsinew.a

$(B)/%.o: %.c
	@mkdir -p $(@D)
	$(call say,CC,$<)
	$(Q)$(CC) $(CPPFLAGS_ALL) $(CFLAGS_ALL) -MMD -MP -c -o $@ $<

# where a program outside of the installation finds what is in libexec
$(B)/lib/io/import.o: CPPFLAGS_ALL += -DSN_PREFIX='"$(PREFIX)"'

# CGAL needs 1-2 GB and up to half a minute a file; its angles decide which triangles are made, so they are ours (sinew/exact.h)
$(BRIDGE)/%.o: lib/geom/%.cpp lib/geom/cgal_symbols
	@mkdir -p $(@D)
	$(call say,CXX,$<)
	$(Q)$(CXX) $(BRIDGE_FLAGS) -MMD -MP -c -o $@ $<
	$(Q)objcopy --redefine-syms=lib/geom/cgal_symbols $@

$(B)/libsinew.a: $(LIB_OBJECTS) $(BRIDGE_OBJECTS)
	@rm -f $@
	$(call say,AR,$@)
	$(Q)ar rcs $@ $^

link = $(CC) $(FLAGS_$(CONFIG)) -pthread -o $@ $(filter %.o,$^) $(B)/libsinew.a -Wl,--as-needed $(foreach l,$(1),$(LINK_$l)) -lm $(LDFLAGS)

$(B)/bin/%: $(B)/tools/%.o $(TOOL_SHARED) $(B)/libsinew.a
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(call link,$(LIBS_$*))

# sources of one tool alone
$(B)/bin/envelope-bind: $(B)/tools/frame_files.o
$(B)/bin/simulate: $(B)/tools/fibers.o $(B)/tools/earlier.o $(B)/tools/contacts.o $(B)/tools/outcome.o $(B)/tools/others.o $(B)/tools/bone_frames.o $(B)/tools/frame_files.o
$(B)/bin/motion-import $(B)/bin/motion-fit: $(B)/tools/clip.o
$(B)/bin/rig-view: $(B)/tools/others.o $(B)/tools/frame_files.o $(B)/tools/motion_view.o $(B)/tools/frame_list.o $(B)/tools/section_view.o
$(B)/bin/motion-import: $(B)/tools/model_bones.o
$(B)/bin/moment-arm: $(B)/tools/arm_input.o
$(B)/bin/attach-detect: $(B)/tools/neighbours.o
$(B)/bin/fiber-fill: $(B)/tools/fiber_architecture.o
$(B)/bin/scene-build: $(B)/tools/model_bones.o $(B)/tools/scene_list.o

$(B)/libexec/sinew/%: $(B)/tools/%.o $(TOOL_SHARED) $(B)/libsinew.a
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(call link,$(LIBS_$*))

$(B)/examples/%: $(B)/share/examples/%.o $(B)/libsinew.a
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(call link,embree mesh json gsl exact)

$(B)/tests/%: $(B)/tests/%.o $(B)/libsinew.a
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(call link,cgal embree sparse gsl mesh json png exact) -lcmocka

tests: $(UNIT_TESTS) $(EXTRA_TESTS)

include share/make/project.mk
include share/make/fuzz.mk

-include $(patsubst %,$(B)/tools/%.d,fibers earlier contacts outcome others bone_frames frame_files motion_view frame_list model_bones scene_list neighbours section_view arm_input) $(LIB_OBJECTS:.o=.d) $(BRIDGE_OBJECTS:.o=.d) $(BUILT_TOOLS:$(B)/bin/%=$(B)/tools/%.d) $(LIBEXEC_TOOLS:%=$(B)/tools/%.d) $(TOOL_SHARED:.o=.d)
-include $(UNIT_TESTS:=.d) $(EXTRA_TESTS:=.d) $(EXAMPLES:$(B)/examples/%=$(B)/share/examples/%.d)
