// Nothing but the headers that targets share precompiled.
