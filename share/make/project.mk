# Targets around the build: dependencies, tests, demo, installation. Included by the Makefile.

deps:
	@share/make/install-packages share/debian-packages.txt

clean:
	rm -rf build
