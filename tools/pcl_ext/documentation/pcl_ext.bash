# bash completion for pcl_ext                               -*- shell-script -*-
# Commands, options and values are those that the program's help names.

_pcl_ext()
{
    local word=${COMP_WORDS[COMP_CWORD]} last=${COMP_WORDS[COMP_CWORD-1]} help type
    COMPREPLY=()
    if [ "$COMP_CWORD" -eq 1 ]; then
        help=$("${COMP_WORDS[0]}" --help | sed -n '/^  [^ ]/{s/^  //; s/ .*//; s/,/ /g; p}')
        COMPREPLY=($(compgen -W "$help" -- "$word"))
        return
    fi
    # One line for each option: its names, then the type of its value.
    help=$("${COMP_WORDS[0]}" "${COMP_WORDS[1]}" --help 2> /dev/null \
        | sed -n '/^  -/{s/^  //; s/  .*//; s/\[=.*//; s/,/ /g; p}')
    type=$(awk -v option="$last" '{
        for (i = 1; i < NF; ++i) if ($i == option && $NF !~ /^-/) print $NF }' <<< "$help")
    case $type in
        *'|'*) COMPREPLY=($(compgen -W "${type//|/ }" -- "$word")) ;;
        '' | OUT | FILE)
            if [[ $word == -* ]]; then
                COMPREPLY=($(compgen -W "$(tr ' ' '\n' <<< "$help" | grep '^-')" -- "$word"))
            else
                compopt -o filenames 2> /dev/null
                COMPREPLY=($(compgen -f -- "$word"))
            fi
            ;;
    esac
}
complete -F _pcl_ext pcl_ext
