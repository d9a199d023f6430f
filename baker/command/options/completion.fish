# What fish asks: where on the line it is.
# SPDX-License-Identifier: GPL-3.0-or-later
function __vxs_needs_command
    set -l words (commandline -opc)
    test (count $words) -eq 1; or begin
        test (count $words) -eq 2; and test "$words[2]" = help
    end
end

function __vxs_is
    set -l words (commandline -opc)
    test (count $words) -ge 2; and test "$words[2]" = $argv[1]
end

# Files that end as "glb|gltf" says, and folders.
function __vxs_files
    string match -r -- "^.*\\.(?:$argv[1])\$|^.*/\$" (complete -C "__fish_command_without_completions "(commandline -ct))
end

complete -c vxs -n 'test (count (commandline -opc)) -eq 1' -a help -d 'help of a command'
