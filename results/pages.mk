# Every page under results/ from the code as it is: `make results`, two at a time, the timed ones last and alone.
#
# Interrupted, it goes on where it was: data sets and runs stay in results/sets and results/runs, with a mark for every
# finished page. After a change of the code, `make clean-results` comes first. Not made here, for each takes hours: the
# tuning of the peers (scenarios/bench/tuned.toml) and the suite grid.
SETS := results/sets
RUNS := results/runs
MAPS := $(RECTMERGE_REAL_MAPS)
RECTBENCH := $(BIN)/rectbench

SIMULATED := leaderboard verdict storeys fleets headline live
REAL := robust unbending worlds live-places
TIMED := growth node
marks = $(1:%=$(RUNS)/%.made)

.PHONY: results clean-results
results: $(MARK)-all
	$(if $(MAPS),,@echo "RECTMERGE_REAL_MAPS is not set: the pages of real maps stay as they are")
	$(MAKE) --no-print-directory -j2 $(call marks,$(SIMULATED) $(if $(MAPS),$(REAL)))
	$(MAKE) --no-print-directory -j1 $(call marks,$(TIMED))

clean-results:
	rm -rf $(SETS) $(RUNS)

$(RUNS)/%.made:
	$(MAKE) --no-print-directory results-$*
	@touch $@

results-leaderboard:
	$(RECTBENCH) leaderboard -o results $(if $(MAPS),--maps $(MAPS))

$(RUNS)/verdict.made: $(RUNS)/leaderboard.made # which makes sets/standard
results-verdict:
	$(RECTBENCH) generate trust --seed 20261 -o $(SETS)/trust
	$(RECTBENCH) run $(SETS)/trust/test --method robust -o $(RUNS)/verdict/trust
	$(RECTBENCH) run $(SETS)/standard/test --method robust -o $(RUNS)/verdict/standard
	$(RECTBENCH) run repetitive --method robust -o $(RUNS)/verdict/repetitive
	$(RECTBENCH) trust $(RUNS)/verdict/* -o results/trust/README.md

results-storeys:
	$(RECTBENCH) generate storeys --seed 4711 -o $(SETS)/storeys
	$(RECTBENCH) run $(SETS)/storeys --method robust -o $(RUNS)/storeys
	$(RECTBENCH) storeys $(RUNS)/storeys -o results/storeys/README.md

results-fleets:
	$(RECTBENCH) generate fleet-3 -o $(SETS)/fleet-3
	$(RECTBENCH) generate fleet-8 -o $(SETS)/fleet-8
	$(RECTBENCH) generate fleet-repetitive --seed 11 -o $(SETS)/fleet-repetitive
	$(RECTBENCH) fleets $(SETS)/fleet-3 $(SETS)/fleet-8 $(SETS)/fleet-repetitive -o results/fleets

results-headline:
	$(RECTBENCH) run headline-test -o $(RUNS)/headline-test
	$(RECTBENCH) headline $(RUNS)/headline-test -o results/headline/README.md

results-live:
	$(RECTBENCH) generate trust --pairs 48 --seed 2026 --format mcap -o $(SETS)/trust-live
	$(RECTBENCH) live $(SETS)/trust-live -o results/live/README.md

results-live-places:
	$(RECTBENCH) live $(MAPS)/real_places -o results/live/real_places.md

results-robust:
	$(RECTBENCH) results $(MAPS) -o results/robust --force

results-unbending:
	$(RECTBENCH) unbending $(MAPS) -o results/unbending/README.md

results-worlds:
	$(RECTBENCH) realism $(MAPS) -o results/worlds --force

results-growth:
	$(BIN)/python -m pytest tests/bench/bench_growth.py -o python_files="bench_*.py" --benchmark-only --benchmark-json=$(RUNS)/growth.json
	$(RECTBENCH) growth $(RUNS)/growth.json -o results/growth --force

results-node:
	$(BIN)/python -m tests.bench.live_node -o results/live/node.md --seeds 3
