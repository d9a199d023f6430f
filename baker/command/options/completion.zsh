# What zsh asks. A function for each command has its options; _vxs_commands has their names and purposes.
# SPDX-License-Identifier: GPL-3.0-or-later
if ((CURRENT == 2)); then
    _describe -t commands command _vxs_commands -- '(help:help\ of\ a\ command)'
elif [[ $words[2] == help ]]; then
    ((CURRENT == 3)) && _describe -t commands command _vxs_commands
elif (($+functions[_vxs_$words[2]])); then
    shift words
    ((CURRENT--))
    _vxs_$words[1]
fi
