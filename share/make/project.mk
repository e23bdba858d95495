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
SHORT_STAMPS := $(STAMPS)/layering $(UNIT_STAMPS) $(CLI_STAMPS)
ALL_STAMPS := $(SHORT_STAMPS) $(PROGRAM_STAMPS) $(STAMPS)/examples $(STAMPS)/anatomy $(STAMPS)/install
EVERYTHING := $(BUILT_TOOLS) $(BUILT_LIBEXEC) $(EXAMPLES) $(wildcard share/schema/*.json) tests/suite

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
$(UNIT_STAMPS): $(STAMPS)/unit-%: $(B)/tests/unit/%
	@DATA=$(DATA) tests/suite $@ unit/$* $<
$(PROGRAM_STAMPS): $(STAMPS)/program-%: $(B)/tests/%
	@DATA=$(DATA) tests/suite $@ $* $<
$(CLI_STAMPS): $(STAMPS)/cli-%: tests/cli/%.bats $(EVERYTHING)
	@BIN=$(CURDIR)/$(B)/bin EXAMPLES=$(CURDIR)/$(B)/examples DATA=$(abspath $(DATA)) CONFIG=$(CONFIG) tests/suite $@ cli/$* bats --tap $<
$(STAMPS)/examples: tests/run-man-examples tests/sample-folder README.md $(wildcard share/man/*.1) $(EVERYTHING)
	@tests/suite $@ examples tests/run-man-examples $(B)/bin $(B)/examples
$(STAMPS)/anatomy: tests/anatomy $(EVERYTHING)
	@tests/suite $@ anatomy tests/anatomy $(B)/bin $(DATA) $(B)/anatomy
$(STAMPS)/install: tests/install $(EVERYTHING) $(B)/libsinew.a
	@tests/suite $@ install tests/install $(CONFIG)

# ---- demo ---------------------------------------------------------------------------------------------------------------------
demo: deps
	@$(MAKE) --no-print-directory -j$(JOBS) programs examples
	@share/examples/arm/demo.sh $(B)/bin $(B)/examples build/demo

# ---- checks of the sources ------------------------------------------------------------------------------------------------------
C_FILES := $(wildcard include/sinew/*.h lib/*/*.[ch] tools/*.[ch] tests/*/*.c share/examples/*/*.c)
format:
	clang-format -i $(C_FILES)
layering:
	tests/layering
lint:
	clang-tidy --quiet $(LIB_SOURCES) $(wildcard tools/*.c) -- $(CPPFLAGS_ALL) -std=c17
	cppcheck --quiet --enable=warning,performance,portability --inline-suppr --error-exitcode=1 -Iinclude -Itools lib tools

# ---- installation ---------------------------------------------------------------------------------------------------------------
define PKG_CONFIG
prefix=$(PREFIX)
libdir=$${prefix}/lib
includedir=$${prefix}/include

Name: sinew
Description: Muscle rigs from surface meshes, and their simulation
Version: $(VERSION)
Cflags: -I$${includedir}
Libs: -L$${libdir} -lsinew
Libs.private: $(sort $(foreach l,cgal embree sparse gsl mesh json png,$(LINK_$l))) -lm -pthread
endef
export PKG_CONFIG

install: programs
	install -d $(DESTDIR)$(PREFIX)/bin $(DESTDIR)$(PREFIX)/libexec/sinew $(DESTDIR)$(PREFIX)/lib/pkgconfig $(DESTDIR)$(PREFIX)/include/sinew \
	    $(DESTDIR)$(PREFIX)/share/man/man1 $(DESTDIR)$(PREFIX)/share/sinew/schema
	install -m 755 $(BUILT_TOOLS) $(DESTDIR)$(PREFIX)/bin
	install -m 755 $(BUILT_LIBEXEC) $(DESTDIR)$(PREFIX)/libexec/sinew
	install -m 644 $(B)/libsinew.a $(DESTDIR)$(PREFIX)/lib
	install -m 644 $(wildcard include/sinew/*.h) $(DESTDIR)$(PREFIX)/include/sinew
	install -m 644 $(wildcard share/man/*.1) $(DESTDIR)$(PREFIX)/share/man/man1
	install -m 644 $(wildcard share/schema/*.json) $(DESTDIR)$(PREFIX)/share/sinew/schema
	@echo "$$PKG_CONFIG" > $(DESTDIR)$(PREFIX)/lib/pkgconfig/sinew.pc
uninstall:
	rm -f $(BUILT_TOOLS:$(B)/bin/%=$(DESTDIR)$(PREFIX)/bin/%) $(DESTDIR)$(PREFIX)/lib/libsinew.a $(DESTDIR)$(PREFIX)/lib/pkgconfig/sinew.pc
	rm -rf $(DESTDIR)$(PREFIX)/libexec/sinew $(DESTDIR)$(PREFIX)/include/sinew $(DESTDIR)$(PREFIX)/share/sinew
	rm -f $(patsubst share/man/%,$(DESTDIR)$(PREFIX)/share/man/man1/%,$(wildcard share/man/*.1))
