def written(counts, version, machine):
    return ""
