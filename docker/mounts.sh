# Which folders of the host the command sees (sourced by docker/run). Each is mounted at its own path.
#
# mount_named FOLDER    one that the caller asks for
# mount_all COMMAND…    the checkout, the working directory, PYTHONPATH, and the folder of every path in COMMAND
# mounts                the result
# shellcheck shell=bash disable=SC2154 # checkout, directory, die: docker/run

mounts=()

# May a folder of the host not be mounted there, because the image has its own?
reserved() {
    case $1/ in
    /usr/src/?* | /usr/local/src/?* | /dev/shm/?*) return 1 ;;
    / | // | /opt/ | /run/ | /var/ | /var/cache/ | /var/lib/) ;;
    /bin/* | /boot/* | /dev/* | /etc/* | /lib/* | /lib64/* | /opt/stack/* | /proc/* | /sbin/* | /sys/* | /usr/*) ;;
    /var/lib/dpkg/* | /var/lock/* | /var/run/*) ;;
    *) return 1 ;;
    esac
}

covered() { # is this path in a folder that is mounted?
    local folder
    for folder in "${mounts[@]}"; do [[ $1/ == "$folder"/* ]] && return; done
    return 1
}

# add FOLDER WORD: mount the folder, because of a word of the command line
add() {
    covered "$1" && return
    reserved "$1" && die "$2: cannot be mounted, the image has its own $1"
    [[ $1 != *$'\n'* ]] || die "$2: a path with a line break cannot be mounted"
    mounts+=("$1")
}

mount_named() {
    [[ -d $1 ]] || die "--mount $1: not a folder"
    add "$(realpath -s -- "$1")" "--mount $1"
    add "$(realpath -- "$1")" "--mount $1"
}

# The folder to mount so that a path can be read, made, renamed or replaced: the nearest one above it.
holder() {
    local folder=${1%/*}
    while [[ $folder && ! -d $folder ]]; do folder=${folder%/*}; done
    if reserved "${folder:-/}" && [[ -d $1 ]]; then folder=$1; fi
    echo "${folder:-/}"
}

# mount_path PATH WORD: a path as written, and where its symbolic links lead
mount_path() {
    local path folder
    case $1 in
    /dev/fd/[3-9]* | /dev/fd/[12]?* | /proc/*/fd/*) die "$2: a pipe of the calling shell cannot be handed on" ;;
    /bin/* | /sbin/* | /usr/bin/* | /usr/sbin/* | /opt/stack/*) return ;; # the image's own programs
    /dev/shm/*) ;;
    /dev/* | /proc/* | /sys/*) return ;; # the same inside
    esac
    for path in "$(realpath -ms -- "$1")" "$(realpath -m -- "$1")"; do
        folder=$(holder "$path")
        # Only what exists, or can be made in a folder that exists, must be a path at all.
        if reserved "$folder" && [[ ! -e $path && ! -d ${path%/*}/ ]]; then continue; fi
        covered "$path" || add "$folder" "$2"
    done
}

mount_words() {
    local word path previous=
    for word; do
        if [[ $previous == -c && ! -e $word ]]; then previous= && continue; fi # a program, not a path
        previous=$word
        for path in "${word%%::*}" "${word#*=}"; do # a test is file::name; option=path
            # What else has no slash lies in the working directory.
            if [[ $path != -* && ($path == */* || $path == .. || -L $path) ]]; then mount_path "$path" "$word"; fi
        done
    done
}

mount_all() {
    local folder sorted
    add "$checkout" "$checkout (the checkout)"
    add "$directory" "$directory (the working directory)"
    while IFS= read -r -d : folder; do
        if [[ $folder == /* && -d $folder ]] && ! reserved "$folder"; then add "$folder" "$folder (in PYTHONPATH)"; fi
    done <<<"$PYTHONPATH:"
    mount_words "$@"
    # A folder within another one comes with it.
    mapfile -t sorted < <(printf '%s\n' "${mounts[@]}" | LC_ALL=C sort -u)
    mounts=()
    for folder in "${sorted[@]}"; do covered "$folder" || mounts+=("$folder"); done
}
