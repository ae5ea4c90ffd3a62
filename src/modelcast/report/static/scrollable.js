// What scrolls sideways is reached by Tab, and only while it does.

const watchScrollable = () => {
  const look = (one) => {
    if (one.scrollWidth > one.clientWidth) {
      one.tabIndex = 0;
      one.setAttribute("role", "group");
      one.setAttribute("aria-label", "Table, scrolls sideways");
    } else ["tabindex", "role", "aria-label"].forEach((name) => one.removeAttribute(name));
  };
  const watching = new ResizeObserver((entries) => entries.forEach(({ target }) => look(target)));
  document.querySelectorAll(".wide").forEach((one) => watching.observe(one));
};

watchScrollable();
