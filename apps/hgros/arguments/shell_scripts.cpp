#include "arguments/shell_scripts.hpp"

namespace hgros::cli {
namespace {

constexpr std::string_view kBash = R"script(# Completion of hgros for bash.
_hgros() {
  local -a words=() lines=()
  local i word line previous='' last whole cut
  # Bash also ends words at = and :, hgros does not.
  for ((i = 1; i <= COMP_CWORD; ++i)); do
    word=${COMP_WORDS[i]}
    if ((i > 1)) && [[ $word == [=:]* || $previous == *[=:] ]]; then
      words[${#words[@]} - 1]+=$word
    else
      words+=("$word")
    fi
    previous=$word
  done
  last=${COMP_WORDS[COMP_CWORD]}
  [[ $last == [=:]* ]] && last=''
  whole=${words[${#words[@]} - 1]}
  cut=${whole%"$last"}
  COMPREPLY=()
  mapfile -t lines < <("${1/#\~/$HOME}" __complete -- "${words[@]}" 2>/dev/null)
  for line in "${lines[@]}"; do
    word=${line%%$'\t'*}
    if [[ $word == :file ]]; then
      compopt -o default 2>/dev/null
    elif [[ $word == "$cut"* ]]; then
      printf -v word '%q' "${word#"$cut"}"
      COMPREPLY+=("$word")
    fi
  done
}
complete -F _hgros hgros
)script";

constexpr std::string_view kZsh = R"script(#compdef hgros
# Completion of hgros for zsh.
_hgros() {
  local -a lines names texts
  local line
  lines=("${(@f)$("${(Q)words[1]}" __complete -- "${(@Q)words[2,CURRENT]}" 2>/dev/null)}")
  for line in "${lines[@]}"; do
    [[ -z $line ]] && continue
    if [[ $line == ':file' ]]; then
      compset -P '--*='
      _files
      continue
    fi
    names+=("${line%%$'\t'*}")
    texts+=("${line/$'\t'/  -- }")
  done
  (( $#names )) && compadd -d texts -a names
}
if [[ $funcstack[1] == _hgros ]]; then
  _hgros "$@"
else
  compdef _hgros hgros
fi
)script";

constexpr std::string_view kFish = R"script(# Completion of hgros for fish.
function __hgros_complete
    set -l before (commandline -opc)
    set -l last (commandline -ct)
    set -q last[1]; or set last ''
    for line in ($before[1] __complete -- $before[2..-1] $last 2>/dev/null)
        if test "$line" = ':file'
            set -l option (string match -r -- '^--[^=]*=' $last; or echo '')
            printf '%s\n' $option(__fish_complete_path (string replace -r -- '^--[^=]*=' '' $last))
        else
            printf '%s\n' $line
        end
    end
end
complete -c hgros -f -a '(__hgros_complete)'
)script";

}  // namespace

std::string_view CompletionScript(std::string_view shell) noexcept {
  if (shell == "bash") return kBash;
  if (shell == "zsh") return kZsh;
  return shell == "fish" ? kFish : std::string_view();
}

}  // namespace hgros::cli
