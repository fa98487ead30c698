"""Files are data: one reader of JSON, TOML and YAML files, the check of their types, and their checksums.

Every file that the package opens at run time goes through `FileReader`, whether a user or the package wrote
it. It opens regular files alone, up to a size, and takes plain values alone: text, numbers, true, false,
null, lists and mappings, of a limited depth. Nothing in a file is imported or run.
"""
