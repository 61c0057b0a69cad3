#!/usr/bin/env bash
# tests/docker/behaviour.sh [--jobs]   what docker/run promises its users, tried by the way it takes here
#
# Run it on the host (Docker, Podman or buildah), or through docker/run (the stack is already there).
# --jobs adds the package's own commands, run from a folder outside the checkout. Ends with the number of failures.
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd -P)
run=$root/docker/run
base=~
[[ ! ${GRADED_FRETTING_STACK-} ]] || base=/tmp
work=$(mktemp -d "$base/docker run.XXXXXX") # with a space, outside the checkout
scratch=$(mktemp -d /tmp/docker-run.XXXXXX)
mkdir -p "$work/own" "$work/other" "$work/a:b,c" "$work/linked"
trap 'rm -rf "$work" "$scratch"' EXIT
failures=0 checks=0

# check NAME COMMAND…: the command must succeed
check() {
    local name=$1 begin=$SECONDS
    shift
    checks=$((checks + 1))
    if "$@" >"$scratch/said" 2>&1; then echo "ok    $name ($((SECONDS - begin)) s)"; return; fi
    echo "FAIL  $name" && sed 's/^/      /' "$scratch/said"
    failures=$((failures + 1))
}

# refused WORD COMMAND…: fails at once, with one line that holds the word
refused() {
    local word=$1 said
    shift
    said=$("$@" 2>&1 >/dev/null) && { echo "not refused" && return 1; }
    echo "$said"
    [[ $(wc -l <<<"$said") == 1 && $said == "docker/run: "*"$word"* ]]
}

mine() { [[ -s $1 && -O $1 && -G $1 ]] || { ls -ln "$1" && return 1; }; }
within() { (cd "$1" && shift && "$@"); }

own_folder() {
    echo one >"$work/own/scene.toml"
    [[ $(within "$work/own" "$run" sh -c 'pwd; cat scene.toml; echo two >made') == "$work/own"$'\n'one ]] &&
        mine "$work/own/made"
}
output() { within "$work/own" "$run" sh -c 'mkdir -p "$0" && echo x >"$0/file"' "$1" && mine "$2/file"; }
output_option() {
    within "$work/own" "$run" sh -c 'echo x >"${0#--output=}"' "--output=$work/other/option" &&
        mine "$work/other/option"
}
replaced() { # a folder given by name may be renamed and made again
    mkdir -p "$work/other/run" && echo x >"$work/other/run/x"
    "$run" sh -c 'mv "$0" "$0.old" && mkdir "$0" && echo y >"$0/y"' "$work/other/run" && mine "$work/other/run/y"
}
odd_names() {
    echo x >"$work/a:b,c/x"
    "$run" cat "$work/a:b,c/x" && within "$work/a:b,c" "$run" cat x
}
linked() {
    echo x >"$work/linked/x" && ln -sfn "$work/linked" "$work/own/link" && ln -sfn "$work/linked/x" "$work/own/x"
    within "$work/own" "$run" cat link/x x && "$run" cat "$work/own/link/x" "$work/own/x"
}
asked_for() {
    echo x >"$work/other/x"
    "$run" --mount "$work/other" --mount="$work/linked" sh -c "cat '$work/other/x' && ls '$work/linked'"
}
unasked() { ! within "$work/own" "$run" sh -c "cat '$work/other/x'"; }
nothing_lost() { ! "$run" sh -c 'echo x >/var/tmp/lost || echo x >/opt/lost || mkdir /lost'; }
in_tmp() {
    echo x >"$scratch/x"
    "$run" cat "$scratch/x" && within "$scratch" "$run" sh -c 'echo y >y' && mine "$scratch/y"
}
new_in_tmp() {
    local new
    new=$(mktemp -du /tmp/new.XXXXXX)
    "$run" sh -c 'mkdir "$0" && echo x >"$0/x"' "$new" && mine "$new/x" && rm -r "$new"
}
environment() {
    mkdir -p "$work/other/lib" && echo 'value = 7' >"$work/other/lib/my_own_module.py"
    OMP_NUM_THREADS=3 PETSC_OPTIONS=-info PYTEST_ADDOPTS=-x OMPI_MCA_btl=self PRTE_MCA_x=1 PYTHONPATH=$work/other/lib \
        "$run" python -c '
import os, my_own_module
names = "OMP_NUM_THREADS", "PETSC_OPTIONS", "PYTEST_ADDOPTS", "OMPI_MCA_btl", "PRTE_MCA_x"
assert [os.environ[name] for name in names] == ["3", "-info", "-x", "self", "1"], os.environ
assert os.environ["GRADED_FRETTING_RUN"].endswith("/docker/run"), os.environ'
}
importable() { within "$work/own" "$run" python -c 'import analytic, forms, simulations'; }
loop() {
    local line lines=0
    while read -r line; do
        "$run" "$@" || return
        lines=$((lines + line))
    done < <(printf '%s\n' 1 2 4)
    ((lines == 7)) || { echo "only $lines of 7" && return 1; }
}
input() { [[ $(echo x | "$run" cat) == x && $(echo 'print(6 * 7)' | "$run" python -) == 42 ]]; }
rank_input() { [[ $(echo x | "$run" mpirun --stdin 0 -n 1 cat) == x ]]; }
rank_status() { "$run" mpirun -n 2 sh -c 'exit 4'; (($? == 4)); }
rank_last_words() { # what a rank writes to mpirun's own stderr is not written over by the next command of a job
    { "$run" mpirun -n 1 sh -c 'echo last words >>/proc/$PPID/fd/2' && echo next >&2; } 2>log
    [[ $(<log) == "last words"$'\n'next ]] || { cat log && return 1; }
}
status() { "$run" sh -c 'exit 7'; (($? == 7)); }
together() {
    local first second
    "$run" mpirun -n 2 sh -c 'sleep 1; echo x >>first' & first=$!
    "$run" mpirun -n 2 sh -c 'sleep 1; echo x >>second' & second=$!
    wait "$first" && wait "$second" && [[ $(wc -l <first) == 2 && $(wc -l <second) == 2 ]]
}
moved() { # a record that differs is named, in the form of /opt/stack/moved.txt
    cp "$root/docker/check-versions" . && sed 's/^gmsh=.*/gmsh=1.0-1/' "$root/docker/versions.txt" >versions.txt
    "$run" ./check-versions --moved >moved.txt && grep -E '^gmsh 1\.0-1 4\.' moved.txt
}
dated() { # the sources of a dated archive
    local archive='^deb \[.*\] http://snapshot.debian.org/archive/debian(-security)?/20260801T000000Z trixie'
    [[ $("$root/docker/install-stack" --sources 20260801T000000Z | grep -cE "$archive") == 3 ]] &&
        ! "$root/docker/install-stack" --sources yesterday
}

cat >"$work/own/tell.py" <<'PROGRAM' # tells which signal it got, and ends by itself
import signal, sys, time
def tell(number, frame):
    open("told", "w").write(str(number))
    sys.exit(130)
signal.signal(signal.SIGINT, tell)
signal.signal(signal.SIGTERM, tell)
open("begun", "w").close()
time.sleep(60)
PROGRAM
told() { # NUMBER JOB COMMAND…: once the program has begun, the command makes the job end with that signal
    local number=$1 job=$2 status=0
    shift 2
    for _ in {1..300}; do [[ -e begun ]] && break; sleep 0.1; done
    "$@"
    wait "$job" || status=$?
    [[ $status == 130 && $(<told) == "$number" ]] || { echo "status $status" && ls && return 1; }
}
signalled() { # NUMBER
    rm -f told begun
    "$run" python tell.py & told "$1" $! kill -s "$1" $!
}
typed() { # Ctrl-C in a terminal
    rm -f told begun keys && mkfifo keys
    script -qec "'$run' python tell.py" /dev/null <>keys >/dev/null & told 2 $! sh -c 'printf "\003" >keys'
}

mpirun_ends() { # SIGNAL STATUS: mpirun itself says 1
    local job status=0
    rm -f begun
    "$run" mpirun -n 2 sh -c 'touch begun; sleep 60' & job=$!
    for _ in {1..300}; do [[ -e begun ]] && break; sleep 0.1; done
    kill -s "$1" "$job"
    wait "$job" || status=$?
    [[ $status == "$2" ]] || { echo "status $status" && return 1; }
}

cd "$work/own" || exit
check "the working directory stays, outside the checkout" own_folder
check "output in another folder, absolute" output "$work/other/new" "$work/other/new"
check "output in another folder, relative" output ../other/relative "$work/other/relative"
check "output in another folder, --output=…" output_option
check "output in folders that are not there yet" output "$work/other/1/2/3" "$work/other/1/2/3"
check "output replaces its folder" replaced
check "a colon, a comma and a space in a path" odd_names
check "symbolic links" linked
check "--mount" asked_for
check "folders below /tmp" in_tmp
check "a new folder in /tmp" new_in_tmp
check "the environment arrives, with PYTHONPATH" environment
check "the package is importable from anywhere" importable
check "a while-read loop keeps its lines, mpirun" loop mpirun -n 2 true
check "a while-read loop keeps its lines, pytest" loop pytest --version
check "a while-read loop keeps its lines, the package's commands" loop sh -c cat python -m simulations.fretting
check "standard input arrives" input
check "standard input arrives at rank 0" rank_input
check "the exit status arrives" status
check "two runs at once" together
check "a package whose version moved is named" moved
check "a dated archive's sources" dated
check "SIGINT ends the command" signalled 2
check "Ctrl-C in a terminal ends the command" typed
check "SIGTERM ends the command" signalled 15
check "SIGINT to mpirun is told by the exit status" mpirun_ends INT 130
check "SIGTERM to mpirun is told by the exit status" mpirun_ends TERM 143
check "and so is what its ranks end with" rank_status
check "a file keeps the last line of a rank" within "$work/own" rank_last_words
for folder in / /usr /etc /bin /lib /proc /opt/stack /var; do
    [[ ! -d $folder ]] || check "--mount $folder is refused" refused "$folder" "$run" --mount "$folder" true
done
check "--mount of nothing is refused" refused "/no/folder" "$run" --mount /no/folder true
check "an unknown option is refused" refused "--bogus" "$run" --bogus true
if [[ ! ${GRADED_FRETTING_STACK-} ]]; then
    check "what is not asked for is not seen" unasked
    check "what would be lost cannot be written" nothing_lost
    check "output in a system folder is refused" refused "/etc/new" "$run" true --output /etc/new
    check "output in / is refused" refused "/new" "$run" true --output=/new
    check "an input in a system folder is refused" refused "/etc/hosts" "$run" cat /etc/hosts
    check "a system folder as working directory is refused" refused "/usr" within /usr "$run" true
fi
# README's scene of one's own, and its command as it stands there
sed -n '/^Write `mine.toml`/,/^and run it there/s/^    //p' "$root/README.md" >mine.toml
mapfile -t own < <(sed -n "s|^    PATH/docker/run \(.* mine.toml .*\)$|\1|p" "$root/README.md" | tr ' ' '\n')
check "README's scene in a folder of one's own, explained" "$run" "${own[@]}" --explain
if [[ ${1-} == --jobs ]]; then
    check "a scene of one's own, output beside it" "$run" python -m simulations.indentation --output results
    check "which belongs to the caller" mine results/summary.json
    check "README's scene in a folder of one's own: ${own[*]}" "$run" "${own[@]}"
    check "which belongs to the caller, too" mine mine/summary.json
    check "a script of the checkout" "$run" python "$root/examples/profiles.py" picture.png
    check "whose picture belongs to the caller" mine picture.png
fi
echo "$checks checks, $failures failed, $SECONDS s"
exit "$failures"
