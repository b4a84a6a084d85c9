// Makes modules of the texts in this file, so that nothing is loaded from elsewhere.
(() => {
  const failed = (sentence) => {
    const place = document.getElementById("failure");
    place.textContent = sentence;
    place.hidden = false;
  };
  window.addEventListener("error", (event) => failed(`The page stopped: ${event.message}.`));
  window.addEventListener("unhandledrejection", (event) => failed(`The page stopped: ${event.reason?.message ?? event.reason}.`));
  const imports = {};
  for (const script of document.querySelectorAll('script[type="text/module"]')) {
    const blob = new Blob([script.textContent], { type: "text/javascript" });
    imports[script.dataset.name] = URL.createObjectURL(blob);
  }
  const map = document.createElement("script");
  map.type = "importmap";
  map.textContent = JSON.stringify({ imports });
  document.head.append(map);
  const main = document.createElement("script");
  main.type = "module";
  main.textContent = 'import "symkin/page";';
  document.head.append(main);
})();
