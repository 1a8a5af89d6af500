#!/usr/bin/env bash
# A farm that loses nothing: two coordinators on PostgreSQL and S3 and four workers on
# this machine render golden-gate, while processes are killed with -9 at random for two
# minutes. At the end the film must have the hash of `shearwater render`.
#
#   deploy/demo.sh                 # two minutes of kills
#   SECONDS_OF_KILLS=30 SPP=64 SEED=7 SIZE=512x256 deploy/demo.sh
#
# It takes what `tests/servers` takes: PostgreSQL and moto (`tests/run` installs both).
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
kills_s=${SECONDS_OF_KILLS:-120}
spp=${SPP:-512}
size=${SIZE:-1024x512}
scene=$here/scenes/golden-gate/scene.json
program=${SHEARWATER:-$here/target/release/shearwater}

if [ -z "${SHEARWATER_TEST_POSTGRES:-}" ]; then
    [ -n "${SHEARWATER:-}" ] || (cd "$here" && cargo build --locked --release)
    exec "$here/tests/servers" "$0"
fi

seed=${SEED:-$((RANDOM))}
RANDOM=$seed
folder=$(mktemp -d)
declare -A pids=()
end_all() {
    trap - EXIT
    for name in "${!pids[@]}"; do kill -9 "${pids[$name]}" 2>/dev/null || true; done
    rm -rf "$folder"
}
trap end_all EXIT

say() { printf '%4d s  %s\n' "$((SECONDS - began))" "$*"; }

free_port() {
    python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'
}
ports=("$(free_port)" "$(free_port)")

# Start coordinator-0, coordinator-1 or worker-0 to worker-3. Even workers talk to the
# first coordinator, odd ones to the second; neither knows of the other.
start() {
    local name=$1 number=${1##*-}
    case $name in
    coordinator-*)
        "$program" coordinator --listen "127.0.0.1:${ports[$number]}" \
            --database "$SHEARWATER_TEST_POSTGRES" --objects "$SHEARWATER_TEST_S3/demo-$$" \
            >>"$folder/$name.log" 2>&1 &
        ;;
    worker-*)
        "$program" worker --threads 1 \
            --coordinator "http://127.0.0.1:${ports[number % 2]}" >>"$folder/$name.log" 2>&1 &
        ;;
    esac
    pids[$name]=$!
    disown
}

# A field of the job, asked of whichever coordinator answers.
ask() {
    local port
    for port in "${ports[@]}"; do
        "$program" status "$job" --json --coordinator "http://127.0.0.1:$port" 2>/dev/null |
            python3 -c "import json,sys; print(json.load(sys.stdin)['$1'])" 2>/dev/null && return
    done
    echo unknown
}

began=$SECONDS
echo "seed $seed; $size at $spp samples; logs in $folder"
echo "what render says:"
right=$("$program" render "$scene" --size "$size" --spp "$spp" --json -o "$folder/right" |
    python3 -c 'import json,sys; print(json.load(sys.stdin)["film_hash"])')
say "film $right"

names=(coordinator-0 coordinator-1 worker-0 worker-1 worker-2 worker-3)
for name in "${names[@]}"; do start "$name"; done
until job=$("$program" submit "$scene" --size "$size" --spp "$spp" --json \
    --coordinator "http://127.0.0.1:${ports[0]}" 2>"$folder/submit.log" |
    python3 -c 'import json,sys; print(json.load(sys.stdin)["id"])' 2>/dev/null); do
    [ $((SECONDS - began)) -lt 600 ] || { cat "$folder/submit.log" >&2; exit 1; }
    sleep 0.5
done
say "job $job is submitted; kills begin"

kills=0 until_s=$((SECONDS + kills_s))
while [ "$SECONDS" -lt "$until_s" ] && [ "$(ask done)" != True ]; do
    name=${names[RANDOM % ${#names[@]}]}
    kill -9 "${pids[$name]}" 2>/dev/null || true
    kills=$((kills + 1))
    say "kill -9 $name ($(ask units_done) of $(ask units_total) units are done)"
    sleep "0.$((RANDOM % 10))"
    start "$name"
    sleep "$((RANDOM % 3)).$((RANDOM % 10))"
done
say "$kills kills; now in peace"
until [ "$(ask done)" = True ]; do sleep 1; done

film=$(ask film_hashes | tr -d "[]' ")
say "film $film"
if [ "$film" != "$right" ]; then
    echo "the films differ" >&2
    exit 1
fi
echo "the same film after $kills kills"
