"""The page docs/evidence/reliability.md: what was tried, how often, what came of it, and what is promised."""

import collections

LEGEND = {
    "faults": ("One call of the system fails",
               "`tests/faults` makes the n-th call fail that asks for memory, opens, reads, writes, closes, renames, …, for n = 1, 2, 3 … or, where "
               "there are more calls than trials, evenly over the run. *Half done*: a read or write that does half of what was asked; *interrupted*: "
               "one that a signal cuts short; both must change nothing. After every trial: the exit code, one line that says what failed, no "
               "file left over, and the earlier result or the new one whole, compared byte by byte but for the times of the run."),
    "kills": ("Killed (SIGKILL)",
              "Before every kind of call, before each of the last calls of the kernel (by strace), and at random times. What stands in the folder "
              "at once, before anybody tidies up; then, after the next run, it must be the earlier result or the new one, and nothing else."),
    "signals": ("Signals at random times",
                "SIGINT (Ctrl-C), SIGTERM and SIGHUP end a run in one line with exit 130 and leave what was there; SIGPIPE and SIGXFSZ, sent from "
                "outside, change nothing."),
    "limits": ("Disk and memory that end", "A limit of file sizes from 0 to beyond the largest file of the result, as a disk that is full; a "
               "limit of memory from less than the program needs to be loaded to more than the run needs."),
    "two runs": ("Two runs into one folder", "Begun at random distances, into a folder with a result and into none."),
    "streams": ("Streams", "Each choice of standard input, output and error closed (no file of a result may take their place), output or error full "
                "(`/dev/full`), a reader that leaves; and inputs of every format through a pipe and a FIFO, which are read as the file."),
    "broken files": ("Broken input", "Files of every format cut short, with bits turned over, counts off by one, bytes zeroed, pieces repeated or left out, "
                     "numbers made extreme; within 3 GB of memory and 30 s of work. Read for what it is, or refused in one line that names it: no crash, no exit 1."),
    "same bits": ("The same bits", "Every file of the result for 1, 2, 3 and 7 threads (but where it names their number); `result.json` with the points of both "
                  "scans in another order."),
    "valgrind": ("Memory errors", "One run of each command under valgrind."),
}

PROMISES = """## What is promised

| | isopach | where it ends |
|---|---|---|
| a file (`convert`, `--json FILE`) | the earlier file or the new one, whole, at any moment, kills and power cuts included | pipes and devices are written as they come |
| a folder of results, after a failure, a signal or a full disk | the earlier result, whole, as soon as the run has ended | a failure after the results are in place (of standard output, say) leaves the new ones, with exit 1 |
| a folder of results, after a kill or a power cut | a `result.json` stands beside the files it lists and no others of a result: the earlier result, the new one, or – if the kill falls between the first and the last renaming – files of both and **no `result.json`**, until the next run into the folder makes it the new result | whoever reads the folder must take a missing `result.json` for "no result"; file by file it cannot be told |
| memory that is not there | exit 1, one line, the earlier result | libraries: below |
| signals | INT, TERM, HUP: one line, exit 130, the earlier result | a second one ends the run at once, as a kill |
| two runs into one folder | one is refused (exit 2) | file systems without locks |
| input that is broken | read for what it is, or exit 3 and one line | a file that is wrong and well-formed is read |
| the same bits | for any number of threads and any order of points | another compiler or processor family may differ in the last bits of what the C library computes |

Several files cannot be replaced in one step: a file system renames one name at a time. The step that would do, exchanging the whole folder for a new one,
would take the folder from under programs that stand in it, could not be done for `-o .` or a mounted folder, and would have to carry files of your own over, which
then could be lost. So the record goes first and comes last, and what is to be renamed is written down before.

## What is not covered

- **Memory, in libraries.** LASzip does not look whether it got memory in some places and crashes, and in others takes it for a broken file ("internal error": exit 3
  or 1); nlohmann-json before 3.11.3 crashes where an object cannot be begun. GDAL ends the program by design ("CPLMalloc", below): that is caught, and
  is one line and exit 1. In all of these the earlier result stays; what they had begun the next run removes. Such crashes are counted in the table, by library.
- **Where nothing may fail.** Parts of the C++ standard library must not throw and need memory all the same (listing a folder): the run ends at once, in one line,
  exit 1, and leaves its unfinished folder to the next run.
- **Before it begins.** With less memory than the program needs to be loaded, or the libraries of GDAL later on, the loader of the
  system speaks, not isopach, and ends with 127.
- **The disk itself.** A power cut was not tried, only that everything is brought to the disk (fsync) before it is renamed; a disk that lies about that is believed.
- Requests of memory inside the C library (buffers of streams) fail as any other; stacks of threads and mapped files are tried by the limit of memory alone.

## What others promise

From their own documentation and issue trackers, read for this page; what is not named there was looked for and not found.

| program | files | memory | kills |
|---|---|---|---|
| SQLite ("How SQLite Is Tested"; "File Locking And Concurrency In SQLite Version 3") | all of a transaction or nothing; a journal is written first | out-of-memory, I/O error, crash and power loss tests, millions of cases: the model of this page | whoever opens the file next rolls a "hot" journal back; isopach leaves the like to the next run into the folder |
| GDAL (documentation of `CPLMalloc`; pull request 12717 "Add capability to create files that have their final name set only at closing", 2025) | that request gives some tools files that get their name at the end; it says of `gdal raster retile` that a file that is there may not be valid if the process crashed while creating it | small requests raise a fatal error: "unlikely to fail", "the application is unwilling to test" | no promise found |
| PDAL (issues 821 and 2609) | "pdal translate still creates output file when unsupported": a corrupt file, since closed; a writer that did not look whether its file could be made, since closed | no promise found | no promise found |
| CloudCompare (issues 986 and 1029, of its command line) | a run that "seems to be executed as expected" and saves nothing; no output to the console | no promise found | no promise found |
"""


def table(rows, section):
    """Fault by outcome, over all verbs."""
    found = collections.defaultdict(collections.Counter)
    verbs = collections.defaultdict(set)
    for of, fault, verb, counts in rows:
        if of == section:
            found[fault].update(counts)
            verbs[fault].add(verb)
    lines = ["| what | trials | verbs or formats | what came of it |", "|---|---|---|---|"]
    for fault, counts in sorted(found.items(), key=lambda item: -sum(item[1].values())):
        came = "; ".join(f"{number} {outcome}" for outcome, number in counts.most_common())
        lines.append(f"| {fault} | {sum(counts.values())} | {len(verbs[fault])} | {came} |")
    return "\n".join(lines)


def total(rows, section=None):
    return sum(sum(counts.values()) for of, _, _, counts in rows if section in (None, of))


def by_verb(rows):
    verbs = collections.Counter()
    for of, _, verb, counts in rows:
        if of != "broken files":
            verbs[verb] += sum(counts.values())
    return ", ".join(f"`{verb}` {number}" for verb, number in verbs.most_common())


def offences(found):
    slow = [o for o in found if o[3].startswith("no end")]
    found = [o for o in found if o not in slow]
    undecided = f" {len(slow)} trials of the most expensive verbs had no end within the limit on a machine with much other work: neither for nor against; they " \
        "stand as *hung* in the tables, and are to be repeated on a quiet one." if slow else ""
    if not found:
        return "Nothing was against the contract." + undecided
    lines = [f"- {section}, {fault}: `{command}`: {what.strip().splitlines()[0][:300]}" for section, fault, command, what in found[:40]]
    return f"**Against the contract: {len(found)}.**{undecided}\n\n" + "\n".join(lines)


def measured(figures):
    if "longest answer to a signal" not in figures:
        return ""
    return f"\n\nFrom a signal to the end of the run it took {figures['longest answer to a signal']:.1f} s at most, on a machine with other work."


def written(counts, version, machine):
    rows = counts["rows"]
    parts = [f"""# Reliability: what becomes of your files when something fails

Written by `bench/reliability.py` ({total(rows)} trials, isopach {version}, {machine.sysname} {machine.machine}). A disk fills, a cable is pulled, somebody presses
Ctrl-C: what stands in the folder then, and what does the program say? Every verb was run on small scans of `simulate` and disturbed, over and over; each trial
was held against the contract: an exit code that fits, exactly one line that says what happened, nothing left over, the earlier result or the new one whole,
an end within a quarter of an hour (the runs take seconds, on a machine that does other work).

{offences(counts.get("offences", []))}

| section | trials |
|---|---|"""]
    sections = [name for name in LEGEND if total(rows, name)]
    parts[0] += "".join(f"\n| [{LEGEND[name][0]}](#{LEGEND[name][0].lower().replace(' ', '-').replace('(', '').replace(')', '')}) | {total(rows, name)} |" for name in sections)
    parts.append(f"Trials by verb, but for broken files: {by_verb(rows)}. The more expensive a verb, the fewer.")
    parts.append(PROMISES.strip())
    for name in sections:
        heading, legend = LEGEND[name]
        parts.append(f"## {heading}\n\n{legend}{measured(counts['measured']) if name == 'signals' else ''}\n\n{table(rows, name)}")
    return "\n\n".join(parts) + "\n"
