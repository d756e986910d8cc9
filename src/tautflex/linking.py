"""Compiled functions: machine code of those that Python calls; the others are built into their callers alone.

By itself Numba optimises and translates every function, then again as a part of each of its callers, and of theirs:
the innermost of ten functions ten times. Two thirds of the compiler's work was on code that nobody called.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

from llvmlite import binding
from numba.core import types
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher


class _PartLibrary(JITCodeLibrary):
    """Code to be linked into that of callers, which optimise it; of its own it has the place of its environment."""

    def finalize(self) -> None:
        code, places = self._final_module, []
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            code.link_in(library._get_module_for_linking(), preserve=True)
        code.verify()
        self._finalize_dynamic_globals()
        for function in code.functions:
            if not function.is_declaration and function.linkage == binding.Linkage.external:
                function.linkage = "linkonce_odr"  # each caller has its copy, and drops it where it is inlined
        for variable in code.global_variables:
            if variable.linkage == binding.Linkage.common:
                places.append(f'@"{variable.name}" = common global ptr null')
        self._shared_module = code
        empty = str(self._codegen._create_empty_module(self.name))
        self._final_module = binding.parse_assembly("\n".join([empty, *places]))
        self._finalize_final_module()


class _PartCompiler(Compiler):
    def define_pipelines(self) -> Any:
        library = _PartLibrary(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        library.enable_object_caching()
        self.state.library = library
        return super().define_pipelines()


class _PartFile(CompileResultCacheImpl):
    def get_filename_base(self, fullname: str, abiflags: str) -> str:
        return f"{super().get_filename_base(fullname, abiflags)}-part"


class _PartCache(FunctionCache):
    _impl_class = _PartFile


class _Part(CPUDispatcher):
    """What compiled functions call."""

    def enable_caching(self) -> None:
        self._cache = _PartCache(self.py_func)


class Kernel(CPUDispatcher):
    """A compiled function, from Python; compiled code sees the part."""

    _cache: Any

    @cached_property
    def part(self) -> _Part:
        """The same function for compiled callers."""
        options = {**self.targetoptions, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        part = _Part(self.py_func, targetoptions=options, pipeline_class=_PartCompiler)
        if isinstance(self._cache, FunctionCache):
            part.enable_caching()
        return part

    @property
    def _numba_type_(self) -> Any:
        return types.Dispatcher(self.part)
