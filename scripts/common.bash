# Shared by the scripts beside it and .ci/run, which source it: where things are, how to build, how to play a bag.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
jobs=$(nproc)

# Where ROS is not part of the distribution, its environment may not have been set up yet.
if [ -z "${ROS_DISTRO:-}" ] && [ -f /opt/ros/noetic/setup.bash ]; then
  set +u
  source /opt/ros/noetic/setup.bash
  set -u
fi

say() { printf '\n== %s\n' "$*"; }
fail() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

# Prints the comment at the top of the calling script, without its marks.
usage() { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; }

# Sets `rank` and `count` to this process's number and that of all, of MPI or a Slurm array; 0 and 1 without these.
share_of_work() {
  if [ -n "${OMPI_COMM_WORLD_RANK:-}" ]; then
    rank=$OMPI_COMM_WORLD_RANK count=$OMPI_COMM_WORLD_SIZE
  elif [ -n "${PMI_RANK:-}" ]; then
    rank=$PMI_RANK count=$PMI_SIZE
  elif [ -n "${SLURM_ARRAY_TASK_ID:-}" ]; then
    rank=$((SLURM_ARRAY_TASK_ID - SLURM_ARRAY_TASK_MIN)) count=$SLURM_ARRAY_TASK_COUNT
  else
    rank=0 count=1
  fi
}

# configure DIRECTORY [CMake arguments...]: quiet unless it fails; keeps what was chosen before. A new folder compiles
# files eight at a time, which is less work in all; for work on the sources, -DCMAKE_UNITY_BUILD=OFF.
configure() {
  local directory=$1
  shift
  local -a arguments=(-S "$root" -B "$directory")
  [ -f "$directory/CMakeCache.txt" ] || arguments+=(-DCMAKE_UNITY_BUILD=ON)
  arguments+=("$@")
  if command -v ccache > /dev/null; then
    arguments+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache -DCMAKE_CUDA_COMPILER_LAUNCHER=ccache)
  fi
  mkdir -p "$directory"
  if ! cmake "${arguments[@]}" > "$directory/configure.log" 2>&1; then
    cat "$directory/configure.log" >&2
    fail "configuring failed (the log above is $directory/configure.log)"
  fi
}

# build DIRECTORY [target...]
build() {
  local directory=$1
  shift
  local -a targets=()
  [ "$#" = 0 ] || targets=(--target "$@")
  local start=$SECONDS
  cmake --build "$directory" -j "$jobs" "${targets[@]}" \
    || fail "building in $directory failed"
  echo "Built in $((SECONDS - start)) s."
}

# play_in_ros BUILD_DIRECTORY ROS_HOME LOG [argument:=value ...]: replay.launch, with a master of its own, so that one
# that runs already is left alone, and without name look-ups.
play_in_ros() {
  local directory=$1 home=$2 log=$3 port
  local free_port='import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'
  shift 3
  port=$(/usr/bin/python3 -c "$free_port")
  (
    set +u
    source "$directory/devel/setup.bash"
    export ROS_MASTER_URI=http://127.0.0.1:$port ROS_IP=127.0.0.1 ROS_HOME=$home
    unset ROS_HOSTNAME
    export PATH=/usr/bin:$PATH
    roslaunch --port "$port" deja_view replay.launch "$@"
  ) > "$log" 2>&1 < /dev/null
}
