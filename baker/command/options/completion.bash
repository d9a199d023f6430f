# What bash asks. _vxs_names[COMMAND] are options; _vxs_values['COMMAND KEY'] is what the value of an option may be, by its name, or an
# operand, by its number from 0 on, or `more` for the last and all that follow: words, `files` and how they end, `text` for anything else, nothing
# for what takes no value.
# SPDX-License-Identifier: GPL-3.0-or-later

# Files that end as one of the arguments, all if there is none, and folders.
_vxs_files()
{
    local ending
    compopt -o filenames 2>/dev/null
    (($#)) || compgen -f -- "$current"
    for ending; do compgen -f -X "!*.$ending" -- "$current"; done
    (($#)) && compgen -d -- "$current"
}

# What may stand for a value or operand of that key.
_vxs_values_of()
{
    local values=${_vxs_values["$command $1"]-${_vxs_values["$command more"]-}}
    case $values in
        files*) _vxs_files ${values#files} ;;
        text) ;;
        *) compgen -W "$values" -- "$current" ;;
    esac
}

_vxs()
{
    local current=${COMP_WORDS[COMP_CWORD]} command=${COMP_WORDS[1]} option= operands=0 over= n word IFS=$' \t\n'
    local commands=${!_vxs_names[*]}
    ((COMP_CWORD == 1)) && commands+=' help --help --version'
    if ((COMP_CWORD == 1)) || [[ $command == help && $COMP_CWORD == 2 ]]; then
        mapfile -t COMPREPLY < <(compgen -W "$commands" -- "$current")
        return
    fi
    COMPREPLY=()
    [[ ${_vxs_names[$command]-} ]] || return
    # which option is waiting for its value, and how many operands there are; bash makes a word of `=`
    for ((n = 2; n < COMP_CWORD; n++)); do
        word=${COMP_WORDS[n]}
        if [[ $option ]]; then
            [[ $word == = ]] || option=
        elif [[ $over || $word == - || $word != -* ]]; then
            ((++operands))
        elif [[ $word == -- ]]; then
            over=1
        elif [[ ${_vxs_values["$command $word"]-} ]]; then
            option=$word
        fi
    done
    [[ $option && $current == = ]] && current=
    if [[ $option ]]; then
        mapfile -t COMPREPLY < <(_vxs_values_of "$option")
    elif [[ ! $over && $current == -* ]]; then
        mapfile -t COMPREPLY < <(compgen -W "${_vxs_names[$command]}" -- "$current")
    else
        mapfile -t COMPREPLY < <(_vxs_values_of "$operands")
    fi
}
complete -F _vxs vxs
