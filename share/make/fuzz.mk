# Coverage-guided fuzzing of every reader, of files and of states, with libFuzzer, after FUZZ_MUTATIONS broken files: make fuzz [FUZZ_SECONDS=60] [FUZZ_TARGETS="obj vtp"]. Included by the Makefile.
# Seeds come from tests/fuzz/mutate_readers and mutate_states; what is found grows build/fuzz/corpus, inputs that break a reader stay in build/fuzz/found.

FUZZ_SECONDS ?= 60
FUZZ_TARGETS ?= obj ply stl off vtk vtp muscle scene pc2 bvh amc asf motion osim mjcf mot nodes sensors body envelope field lines gltf state
FUZZ_CC ?= clang
F := build/fuzz
# memory: ten times the largest input and 64 MB, and what the sanitizers take themselves
FUZZ_INPUT := 65536
FUZZ_OPTIONS := -max_len=$(FUZZ_INPUT) -timeout=5 -malloc_limit_mb=65 -rss_limit_mb=1024 -print_final_stats=1 -verbosity=0
FUZZ_FLAGS := -std=c17 -Wno-psabi -O1 -g -fno-omit-frame-pointer -ffp-contract=off -pthread -fsanitize=address,undefined -fno-sanitize-recover=undefined
# what the readers are made of, but for Embree and CHOLMOD
FUZZ_SOURCES := $(filter-out lib/geom/embree.c lib/geom/sparse.c,$(sort $(wildcard lib/base/*.c lib/geom/*.c lib/motion/*.c lib/io/*.c)))
FUZZ_OBJECTS := $(FUZZ_SOURCES:%.c=$(F)/%.o)
# and what a state is stepped with
FUZZ_SIM_OBJECTS := $(patsubst %.c,$(F)/%.o,lib/geom/sparse.c $(sort $(wildcard lib/sim/*.c)))
FUZZ_SEEDERS := $(B)/tests/fuzz/mutate_readers $(B)/tests/fuzz/mutate_states

.PHONY: fuzz fuzz-run
fuzz: deps
	@share/make/install-packages share/debian-packages-fuzz.txt
	@$(MAKE) --no-print-directory -j$(JOBS) $(FUZZ_SEEDERS) $(FUZZ_TARGETS:%=$(F)/fuzz-%)
	@$(MAKE) --no-print-directory fuzz-run
FUZZ_MUTATIONS ?= 100000
fuzz-run:
	@$(B)/tests/fuzz/mutate_readers $(FUZZ_MUTATIONS)
	@tests/fuzz/run $(F) "$(FUZZ_SEEDERS)" $(FUZZ_SECONDS) "$(FUZZ_OPTIONS)" $(FUZZ_TARGETS)

$(F)/%.o: %.c
	@mkdir -p $(@D)
	$(call say,CC,$<)
	$(Q)$(FUZZ_CC) $(CPPFLAGS_ALL) $(FUZZ_FLAGS) -fsanitize=fuzzer-no-link -MMD -MP -c -o $@ $<
$(F)/libsinew.a: $(FUZZ_OBJECTS)
	@rm -f $@
	$(call say,AR,$@)
	$(Q)ar rcs $@ $^
$(F)/fuzz-%: tests/fuzz/targets/reader.c $(F)/libsinew.a
	$(call say,LINK,$@)
	$(Q)$(FUZZ_CC) $(CPPFLAGS_ALL) $(FUZZ_FLAGS) -fsanitize=fuzzer -DTARGET_$* -o $@ $< $(F)/libsinew.a \
	    -Wl,--as-needed $(LINK_mesh) $(LINK_json) $(LINK_gsl) $(LINK_exact) -lm
$(F)/fuzz-state: tests/fuzz/targets/state.c tests/fuzz/states.h $(FUZZ_SIM_OBJECTS) $(F)/libsinew.a
	$(call say,LINK,$@)
	$(Q)$(FUZZ_CC) $(CPPFLAGS_ALL) $(FUZZ_FLAGS) -fsanitize=fuzzer -o $@ $< $(FUZZ_SIM_OBJECTS) $(F)/libsinew.a \
	    -Wl,--as-needed $(LINK_sparse) $(LINK_mesh) $(LINK_json) $(LINK_gsl) $(LINK_exact) -lcmocka -lm

-include $(FUZZ_OBJECTS:.o=.d) $(FUZZ_SIM_OBJECTS:.o=.d)
